"""V34: H's lemmas on the Noether map of one step, with their constants (H 2.3.4)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Array,
    DataFrame,
    Estimate,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    always,
    estimate,
    failure,
    fewer,
    of_motion,
    readings,
    rows,
    scaled,
    table_of,
    times,
    with_arguments,
)
from benchmarks.claims.vector_spaces.kepler_orbit import problem
from benchmarks.claims.vector_spaces.noether_map import (
    CURVE,
    LOCAL,
    Step,
    exact_motion,
    generator,
    step_of,
)
from benchmarks.measures.independent_space import lagrange_at_chebyshev
from references.closed_forms.kepler_action import kepler_action

NS = (3, 4, 5, 6)
RULES: Mapping[str, Callable[[int], int]] = {
    "2 n points": lambda n: 2 * n,
    "n points": lambda n: n,
    "n - 1 points": lambda n: n - 1,
}
RICH, POOR = "2 n points", "n - 1 points"
HATS, LINE = "Lagrange's phi_1 on Chebyshev points", "1 - t / h"
PRINTED, PROVED = "lemma 2.3.3, left over right", "L_1 and the rule, left over right"
NOETHER, RULE = "distance of I_d from p . a", "error of the rule over that in W^{1,1}"
SECOND = "lemma 2.3.4, left over right"
WHOLE, RATE = "distance of the curve in W^{1,1}", "largest distance of q'"
LIPSCHITZ = "(|q| + |q'|) / |q''|"
GLOBAL, FIRST = "(2.23), left over right", "|I(local motion) - I(start)| in the first step"
KEPT, GENERATED = "change of p . a(q)", "distance of -D1 and D2 of the action from p"
SIDES = (PRINTED, PROVED, NOETHER, RULE, SECOND)
ROUND_OFF = 1e-13  # of numbers of size 1
DIFFERENCE_STEP = 1e-3  # of a difference, whose order is 6
STENCIL = ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Ratios of both sides of the lemmas in one step for each rule, with phi_1 in `label`, and
    along a run; and for exact motions the change of p . a(q) and the momenta that the exact
    discrete Lagrangian generates, over the step."""
    table = in_a_run(make_method, 13 if quick else 100)
    for name, points in RULES.items():
        report(name)
        for n, j in product(NS, range(2, 9, 2 if quick and name != RICH else 1)):
            method = make_method(galvi.Polynomials(n - 1), galvi.gauss(points(n)))
            h = 2.0 ** (-j / 2)
            run = galvi.integrate(problem(), method, h, 1)
            step, where = step_of(problem(), run, points(n)), {"study": name, "n": n, "step": h}
            for label, phi in functions(n).items():
                sides = dict.fromkeys(SIDES, math.nan) if step is None else of_step(step, phi)
                table += rows(sides, label=label, status=failure(run), **where)
    for start, h in product((0.0, 1.0), (0.25, 0.5, 1.0)):
        table += rows(of_exact_motion(problem(start), h), step=h)
    return table_of(table)


def functions(n: int) -> dict[str, Array]:
    """Name -> a phi_1, (n,): H's, and a straight line, with which a basis of the same space may
    begin."""
    first, second, *_ = np.eye(n)
    return {HATS: lagrange_at_chebyshev(n - 1)[0], LINE: 0.5 * (first - second)}


def of_step(step: Step, phi: Array) -> dict[str, float]:
    """The ratios of lemmas 2.3.3 and 2.3.4 in a step, and norms of the curve's distance."""
    size, norms = float(np.linalg.norm(step.a)), step.norms
    curve, exact = (step.noether(name, phi) for name in (CURVE, LOCAL))
    rule_error = step.rule_error(LOCAL, phi)
    error, change = (
        np.linalg.norm(rule_error),
        np.linalg.norm(step.rule_error(CURVE, phi) - rule_error),
    )
    w11_norm = norms["q in L^1"] + norms["q' in L^1"]
    q, p = step.motions[LOCAL](step.h * np.array([0.0, 0.5, 1.0]))
    momentum = np.sum(p * generator(q), axis=1)
    sides = {
        PRINTED: abs(curve - exact) / (size * math.prod(step.right_side(phi))),
        PROVED: abs(curve - exact) / (size * (step.lipschitz * norms["q in L^1"] + change)),
        NOETHER: abs(curve - step.run.p[0] @ step.a),
        RULE: change / w11_norm,
        WHOLE: w11_norm,
        RATE: norms["q'"],
        LIPSCHITZ: (norms["q"] + norms["q'"]) / norms["q''"],
    }
    if error >= 1e-11:  # round-off is 1e-15 of numbers of size 1
        sides[SECOND] = np.max(abs(exact - momentum)) / (size * error)
    return sides


def in_a_run(make_method: MakeMethod, steps: int) -> list[dict[str, Any]]:
    """Rows on (2.23) over the steps of a run with n = 4 and h = 0.5; C and C_a are the largest
    along the run."""
    method, phi = make_method(galvi.Polynomials(3), galvi.gauss(8)), functions(4)[HATS]
    current, sides = problem(), []
    momentum = current.v0 @ generator(current.q0)
    for _ in range(steps):
        run = galvi.integrate(current, method, 0.5, 1)
        step = step_of(current, run, 8)
        if step is None:
            return rows({GLOBAL: math.nan, FIRST: math.nan}, status=failure(run))
        left = abs(step.exact.p[0] @ step.a - momentum)
        sides.append((left, np.linalg.norm(step.a), *step.right_side(phi)))
        current = replace(current, q0=run.q[1], v0=run.p[1])
    left, size, constant, norms = np.array(sides).T
    over = left / (4.0 * np.max(constant) * np.max(size) * norms)
    return rows({GLOBAL: np.max(over), FIRST: left[0]})


def of_exact_motion(start: Problem, h: float) -> dict[str, float]:
    """The change of p . a(q) in an exact motion; and the largest component of p_0 + D_1 L_d and
    p_1 - D_2 L_d, where L_d is the action between its ends."""
    q, p = exact_motion(start.q0, start.v0)(np.linspace(0.0, h, 9))
    momentum, slopes = np.sum(p * generator(q), axis=1), np.zeros((2, 2))
    for index in np.ndindex(2, 2):
        shifts = np.zeros((2, 2))
        shifts[index] = DIFFERENCE_STEP
        for k, weight in STENCIL:
            after, before = (
                kepler_action(1.0, q[0] + x * shifts[0], q[-1] + x * shifts[1], h) for x in (k, -k)
            )
            slopes[index] += weight * (after - before)
    gaps = slopes * [[-1.0], [1.0]] / DIFFERENCE_STEP - p[[0, -1]]
    return {KEPT: np.ptp(momentum), GENERATED: np.max(abs(gaps))}


def read(table: DataFrame) -> dict[str, Measurement]:
    """The largest ratios of lemma 2.3.3 and its hypotheses, of lemma 2.3.4 and of (2.23), and
    numbers of exact motions."""

    def largest(quantity: str, **where: str) -> float:
        return readings.largest_of(table, quantity=quantity, **where)

    def order(quantity: str, n: int) -> Estimate:
        where: Any = {"study": RICH, "label": HATS, "n": n}
        return estimate(readings.order(table, ROUND_OFF, quantity=quantity, **where))

    def share(n: int) -> Estimate:
        """The order of the distance in W^{1,1} over h times the largest distance of q'."""
        distance, rate = order(WHOLE, n), order(RATE, n)
        scatter = math.hypot(distance.uncertainty or 0.0, rate.uncertainty or 0.0)
        refuted = distance.refuted or rate.refuted
        return Estimate(distance.value - rate.value - 1.0, scatter, refuted)

    def farthest(several: Sequence[Estimate], size: Callable[[float], float]) -> Estimate:
        """The estimate whose value has the largest `size`, or one that is refuted or NaN."""
        return max(
            several,
            key=lambda fitted: (fitted.refuted, math.isnan(fitted.value), size(fitted.value)),
        )

    scope = "all rules, phi_1, n and h"
    return {
        f"largest of {PRINTED}, {scope}": largest(PRINTED),
        f"largest {NOETHER}, {scope}": largest(NOETHER),
        f"largest of {PROVED}, phi_1 = {LINE}, all rules, n and h": largest(PROVED, label=LINE),
        "order of (|d| + |d'|) / |d''| in L^infinity, farthest from 1 over n": (
            farthest([order(LIPSCHITZ, n) for n in NS], lambda value: abs(value - 1.0))
        ),
        f"largest {RULE}, {RICH}": largest(RULE, study=RICH),
        f"largest {RULE}, {POOR}, phi_1 = {HATS}": largest(RULE, study=POOR, label=HATS),
        "order of |d|_W11 / (h |d'|_L^infinity), largest over n": (
            farthest([share(n) for n in NS], lambda value: value)
        ),
        f"largest of {SECOND}, {scope}": largest(SECOND),
        f"largest of {GLOBAL}": largest(GLOBAL),
        FIRST: largest(FIRST),
        f"largest {KEPT} on exact motions": largest(KEPT),
        f"largest {GENERATED}": largest(GENERATED),
    }


SHORTENED = fewer(__name__, NS=(4,))
MAP = Step.__module__
NO_SYMMETRY = always(lambda q: q * np.array([1.0, 0.0]))
FAULTS = {
    "H (2.4) without the minus": Fault(wrong={f"{MAP}.momentum": scaled(-1.0), **SHORTENED}),
    "another force": of_motion(
        lambda start: replace(start, system=galvi.Canonical(1.0, galvi.CentralForce(1.0 + 1e-9))),
        wrong=SHORTENED,
    ),
    "the action of another motion": Fault(
        wrong={
            f"{__name__}.kepler_action": with_arguments(
                lambda gm, *ends: (gm * (1.0 + 1e-9), *ends)
            ),
            **SHORTENED,
        }
    ),
    "a phi_1 that does not vanish at the end": Fault(
        wrong={
            f"{__name__}.functions": lambda original: (
                lambda n: {name: phi + 1e-3 * np.eye(n)[0] for name, phi in original(n).items()}
            ),
            **SHORTENED,
        }
    ),
    "Lagrange's phi_1 for the straight line": Fault(
        wrong={
            f"{__name__}.functions": lambda original: (
                lambda n: dict.fromkeys((HATS, LINE), original(n)[HATS])
            ),
            **SHORTENED,
        }
    ),
    "a(q) of no symmetry": Fault(
        wrong={f"{MAP}.generator": NO_SYMMETRY, f"{__name__}.generator": NO_SYMMETRY, **SHORTENED}
    ),
    "local motions of another momentum": Fault(table=times(1e5, quantity=GLOBAL)),
    "ends that are exact": Fault(table=times(0.0, quantity=FIRST)),
    "curves as smooth as motions": Fault(table=times(1.0, power=-1.0, quantity=LIPSCHITZ)),
    "distances of a higher order": Fault(table=times(1.0, power=1.0, quantity=WHOLE)),
    "a right side that is smaller": Fault(table=times(1e3, quantity=PRINTED)),
    "a rich rule that errs more": Fault(table=times(1e3, quantity=RULE, study=RICH)),
    "a poor rule that errs less": Fault(table=times(0.5, quantity=RULE, study=POOR)),
}
