"""V15: Noether quantities, discrete and along the curve (H theorems 2.3.10 and 2.3.11)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    Trajectory,
    at_fixed_time,
    failure,
    history,
    method_of,
    readings,
    refine,
    rows,
    table_of,
    times,
)
from benchmarks.measures import independent_invariants
from benchmarks.measures.errors import angular_momentum_errors
from benchmarks.measures.space_rule_pairs import SUFFICIENT_POINTS, kinds, methods
from references.closed_forms.kepler import KEPLER

ANGULAR, LINEAR = "angular momentum", "linear momentum"
ROTATION, TRANSLATION = "rotation", "translation"
MIXED = {3: (5, 2), 4: (5, 3), 5: (6, 4)}  # n of the lower degree: degrees of the components
ALONG = "angular momentum along the curve, n = 8"
LONG_STEP, LONG_STEPS = 0.5, 8000
THREE_BODIES = Problem(  # in space, with nonzero total momentum
    galvi.NBody(np.array([1.0, 0.2, 0.1])),
    np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [-0.3, 3.0, 0.0]]),
    np.array([[0.1, -0.2, 0.3], [0.1, 0.9, 0.3], [-0.5, -0.2, 0.2]]),
    name="three bodies in space",
)


def pair_on_a_line() -> Problem:
    """Two points on a line with V = r^2 / 2 + r^4 / 4, r = q1 - q2, which is invariant under
    translations."""

    def gradient(q: Array) -> Array:
        pull = q - q[::-1]
        return pull + pull**3

    def potential(q: Array) -> float:
        r = q[0] - q[1]
        return float(0.5 * r**2 + 0.25 * r**4)

    system = galvi.Canonical(1.0, potential, gradient)
    return Problem(system, np.array([1.0, -0.5]), np.array([0.3, 0.4]))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Changes of momenta at step ends for each kind of space, in roundings; with degrees by
    component, the angular momentum's over h; and a history of the largest errors along each
    step."""
    observations = []
    pairs = (
        ((2,), (1, 2, 3, SUFFICIENT_POINTS))
        if quick
        else ((1, 2, 3, 4), (1, 2, 3, 4, 6, SUFFICIENT_POINTS))
    )
    for pair, method in methods(make_method, *pairs):
        report(f"{pair.kind} with {pair.family}")
        run = galvi.integrate(THREE_BODIES, method, 0.1, 100 if quick else 500)
        observations += rows(
            changes_of_momenta(run),
            study=pair.kind,
            n=pair.space.dimension,
            status=failure(run),
        )
    cases = at_fixed_time(MIXED, 25.0, [round(70 * 2 ** (k / 2)) for k in range(7)])
    options = (["angular momentum error"], make_method, report, by_component)
    observations += refine(ROTATION, galvi.problems.kepler(0.3), KEPLER, cases, *options)
    for n in MIXED:
        run = galvi.integrate(pair_on_a_line(), by_component(make_method, n), 25.0 / 70, 70)
        change = changes_of_momenta(run)[LINEAR]
        observations += rows({LINEAR: change}, study=TRANSLATION, n=n, status=failure(run))
    return table_of(observations + along_a_run(method_of(make_method, 8)))


def by_component(make_method: MakeMethod, n: int) -> Any:
    """The method with the degrees of MIXED[n]."""
    return make_method(galvi.ComponentPolynomials(MIXED[n]), galvi.gauss(max(MIXED[n])))


def changes_of_momenta(run: Trajectory) -> dict[str, float]:
    """The largest changes of the sums of m q x v and of p over the bodies, in roundings.

    A unit is the largest sum of |q| |p| or |p| times a random walk of one rounding, 2^-52, a step.
    NaN for a failed run.
    """
    if not run.success:
        return {ANGULAR: math.nan, LINEAR: math.nan}
    angular = independent_invariants.angular_momentum(run.problem, run.q, run.v)
    p = run.p.reshape(*run.p.shape[:2], -1)  # by body
    q_size, p_size = (np.linalg.norm(x.reshape(p.shape), axis=2) for x in (run.q, p))
    walk = 2.0**-52 * math.sqrt(len(p) - 1)
    changes = {ANGULAR: angular - angular[0], LINEAR: np.sum(p - p[0], axis=1)}
    sizes = {ANGULAR: q_size * p_size, LINEAR: p_size}
    return {
        name: float(np.max(np.abs(change)) / (walk * np.max(np.sum(sizes[name], axis=1))))
        for name, change in changes.items()
    }


def along_a_run(method: Any) -> list[dict[str, Any]]:
    """Rows of the largest error along the curve of each step, at the time of its end, over the
    largest error along single steps of the same size from exact states round the orbit."""
    orbit = galvi.problems.kepler(0.6)
    exact = KEPLER.run(orbit, 2.0 * np.pi, {"samples": 400})
    starts = [replace(orbit, q0=q, v0=v) for q, v in zip(exact.q, exact.v, strict=True)]
    single = [errors_along(start, method, 1)[0] for start in starts]
    errors = errors_along(orbit, method, LONG_STEPS) / np.max(single)
    t = np.linspace(LONG_STEP, LONG_STEP * LONG_STEPS, LONG_STEPS)
    return history(ALONG, t, errors, study="history", n=8, step=LONG_STEP)


def errors_along(start: Problem, method: Any, steps: int) -> Array:
    """The largest error of the angular momentum at 11 points of each step, (steps,); NaN for a
    failed run."""
    run = galvi.integrate(start, method, LONG_STEP, steps, curves=True)
    if not run.success:
        return np.full(steps, math.nan)
    t = (np.arange(steps)[:, None] + np.linspace(0.0, 1.0, 11)) * LONG_STEP
    along = angular_momentum_errors(run, t.ravel()).reshape(t.shape)
    return np.max(np.abs(along), axis=1)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The largest changes for each kind of space, with the number of its methods; the orders with
    degrees by component; and the drift along the curve."""
    numbers: dict[str, Measurement] = {
        "change of linear momentum, translation, degrees by component [roundings]": (
            readings.largest_of(table, study=TRANSLATION)
        ),
        f"error of {ALONG}, over the largest of single steps from exact states": (
            readings.drift(table, study="history", quantity=ALONG)
        ),
    }
    for n, degrees in MIXED.items():
        numbers[f"order of the change of angular momentum, degrees {degrees}"] = readings.order(
            table, 1e-14, study=ROTATION, n=n
        )
    for number, kind in enumerate(kinds(), 1):
        for quantity in (ANGULAR, LINEAR):
            changes = readings.values(table, study=kind, quantity=quantity)
            name = f"change of {quantity} at step ends, {kind} [roundings]"
            numbers |= {name: readings.largest(changes), f"methods{number}": float(changes.size)}
    return numbers


def leaking(original: Callable[..., Trajectory]) -> Callable[..., Trajectory]:
    """The function with momenta that grow by 1e-12 over the run, for a planted fault."""

    def run(*problem_and_method: Any, **options: Any) -> Trajectory:
        motion = original(*problem_and_method, **options)
        growth = np.linspace(1.0, 1.0 + 1e-12, len(motion.t))
        return replace(motion, p=motion.p * growth.reshape(-1, *[1] * (motion.p.ndim - 1)))

    return run


FAULTS = {
    "a momentum that leaks": Fault(wrong={"galvi.integrate": leaking}),
    "an order more": Fault(table=times(1.0, power=1.0, study=ROTATION)),
}
