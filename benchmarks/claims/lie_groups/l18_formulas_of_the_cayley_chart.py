"""L18: H's formulas for the free body in Cayley's chart, as printed (H 3.2.2, 3.4.1 to 3.4.3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    Trajectory,
    fewer,
    method_on_group,
    of_table,
    pick,
    readings,
    row,
    rows,
    scaled,
    table_of,
    with_arguments,
)
from benchmarks.claims.lie_groups import free_body, pendulum_motion, printed_formulas
from benchmarks.claims.lie_groups.cayley_curve import cayley_rate
from benchmarks.claims.lie_groups.printed_formulas import (
    MOMENTS,
    BodySteps,
    ScaledRotations,
    departures,
    lagrangian_of,
)
from benchmarks.measures.independent_space import gauss_points
from references.textbook.galerkin import Galerkin, Rotations

PROBLEMS = {"free": free_body.problem, "pendulum": pendulum_motion.problem}
SCALES = (-0.5, 10.0)  # galvi's xi is -2 times H's
N, STEP, STEPS = 4, 0.5, 2
STATES, BODY_STEPS = 100, 6
SIZES = tuple(2.0 ** (-j / 4) for j in range(12, 25))
P0 = MOMENTS * [2.0, -1.9, 1.0]
STAGES = "largest (3.51) along galvi's steps, i = 2 to n - 1, over |p|"
PAIRS = "(3.50) as printed, departure, least over a, b, c any order of axes, with either sign"
SIZE = "change of |y| in a step, relative, base"
ORDERS, NUMBERS = (3, 4, 5), "numbers"
WHOLE = "change of the momentum in space in a step, relative, base"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Distances of steps by scaled charts and by galvi; departures of the formulas from the truth
    at random states; and changes of the momentum in steps whose chart has its base held or moved,
    in one step also over h."""
    numbers: dict[str, float] = {}
    for name, make_problem in PROBLEMS.items():
        report(f"steps by scaled charts, {name}")
        problem = make_problem()
        L = lagrangian_of(problem)
        unscaled, *scaled = (
            Galerkin(N, *gauss_points(N), chart).run(L, problem.q0, problem.v0, STEP, STEPS)
            for chart in (Rotations(), *map(ScaledRotations, SCALES))
        )
        run = galvi.integrate(problem, method_on_group(make_method, N), STEP, STEPS)
        numbers |= {
            f"largest distance between steps by Phi(s xi) and by Phi(xi), {name}": max(
                distance(motion, unscaled) for motion in scaled
            ),
            f"largest distance between galvi's steps and those by H's Phi(xi), {name}": distance(
                run, unscaled
            ),
        }
        if name == "free":
            numbers[STAGES] = largest_stage_sum(run)
    rng = np.random.default_rng(350)
    largest = DataFrame([departures(rng) for _ in range(STATES)]).max()
    readings_of = largest.index.str.startswith("reading")
    numbers[PAIRS] = largest[readings_of].min()
    numbers |= largest[~readings_of].add_suffix(", departure")
    changes: list[float] = []
    for n in (3, 4, 5, 8):
        report(f"momentum, n = {n}")
        rules = (n, n + 1, 2 * n)  # H leaves the points of Gauss's rule open
        held, moved = (
            [BodySteps(n, m, STEP, printed).momenta(P0, BODY_STEPS) for m in rules]
            for printed in (True, False)
        )
        sizes = [np.linalg.norm(y, axis=1, keepdims=True) for y in held]
        numbers[f"{SIZE} held as printed, least over the rules, n = {n}"] = min(
            map(largest_change, sizes)
        )
        changes += map(largest_change, moved)
    numbers[f"largest {WHOLE} moved, all n and rules"] = max(changes)
    series = [
        row(
            quantity=WHOLE,
            n=n,
            step=h,
            value=largest_change(BodySteps(n, n, h, True).momenta(P0, 1)),
        )
        for n in ORDERS
        for h in SIZES
    ]
    return table_of([*rows(numbers, study=NUMBERS), *series])


def distance(first: Any, second: Any) -> float:
    """The largest difference of two motions in R or p."""
    return np.max([np.max(abs(first.q - second.q)), np.max(abs(first.p - second.p))])


def largest_change(y: Array) -> float:
    """The largest change in a step of momenta (k, 3), or of their sizes (k, 1), over |P0|."""
    return np.max(np.linalg.norm(np.diff(y, axis=0), axis=1)) / np.linalg.norm(P0)


def largest_stage_sum(run: Trajectory) -> float:
    """The largest sum (3.51) over i = 2 to n - 1 and galvi's steps, whose xi is -2 times H's, over
    |P0|."""
    c, b = gauss_points(N)
    table = Galerkin(N, c, b, Rotations())
    sums = []
    for t in run.t[:-1]:
        times = t + STEP * np.concatenate([[0.0], c])
        xi, rate = cayley_rate(run(times), run.velocity(times))
        for value, slope in zip(table.phi[1:-1], table.rates[1:-1] / STEP, strict=True):
            terms = printed_formulas.stage_terms(-0.5 * xi[1:], -0.5 * rate[1:], value, slope)
            sums.append(STEP * b @ terms)
    return np.max(np.linalg.norm(sums, axis=1)) / np.linalg.norm(P0)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The numbers, and the order in h of the momentum that is lost in a step."""
    plain = pick(table, study=NUMBERS)
    numbers: dict[str, Measurement] = dict(zip(plain["quantity"], plain["value"], strict=True))
    for n in ORDERS:
        order = readings.order(table, 1e-14, quantity=WHOLE, n=n)
        numbers[f"order of the {WHOLE} held as printed, n = {n}"] = order
    return numbers


def turned_back(original: Callable[..., Array]) -> Callable[..., Array]:
    """The formula with the opposite sign of its cross product, for a planted fault."""
    return lambda first, point: -original(-np.array(first), -np.array(point))


FORMULAS = "benchmarks.claims.lie_groups.printed_formulas"
SHORTENED = fewer(__name__, SCALES=(10.0,), STEPS=1, STATES=10, BODY_STEPS=1, SIZES=())
SLOPES = with_arguments(lambda xi, rate, value, slope: (xi, rate, (1.0 + 1e-9) * value, slope))
WRONG: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
    "a cross product in lambda": (f"{FORMULAS}.composed", turned_back),
    "a cross product in xi_k": (f"{FORMULAS}.relative", turned_back),
    "(3.51) off by 1e-9": (f"{FORMULAS}.stage_terms", SLOPES),
    "a base held": (f"{__name__}.BodySteps", with_arguments(lambda *steps: (*steps[:-1], True))),
    "A off by 1e-9": (f"{FORMULAS}.ScaledRotations.carried", scaled(1.0 + 1e-9)),
    "velocities off by 1e-9": (f"{FORMULAS}.ScaledRotations.velocity", scaled(1.0 + 1e-9)),
    "T off by 1e-9": (f"{FORMULAS}.ScaledRotations.tangent", scaled(1.0 + 1e-9)),
}
FAULTS = {
    "integral off by 1e-9": of_table(integral=1.0 + 1e-9, wrong=SHORTENED),
    "another chart": Fault(
        make=lambda space, rule, chart: galvi.Galerkin(space, rule, galvi.Exponential()),
        wrong=SHORTENED,
    ),
    **{
        name: Fault(wrong={target: change, **SHORTENED}) for name, (target, change) in WRONG.items()
    },
}
