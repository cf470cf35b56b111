"""Whether the errors of Galerkin curves keep pace with those of step ends: the last rows of V33."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    ORACLES,
    Case,
    DataFrame,
    Estimate,
    MakeMethod,
    Measurement,
    Report,
    convergence_fits,
    estimate,
    number,
    readings,
    refine,
    series,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    STEP,
    STEPS,
    convergence_of_polynomials,
    fixed_number,
    in_as_many_steps,
    oracles,
    problem,
)
from benchmarks.claims.vector_spaces.v04_kepler_curve_error_in_n import FROM, POWER
from references.closed_forms.kepler import KEPLER

IN_N = "Kepler, %d steps"
FLOORS = {1: 1e-14, 10: 1e-13, STEPS: 2e-11}  # by number of steps, round-off of the step ends
NS = (3, 4, 5, 6)
IN_H = {10: ENDS_AND_CURVE, STEPS: (ENDS_AND_CURVE[1], "angular momentum error along the curve")}
IN_H_FLOOR = 1e-13  # round-off of the errors in 100 short steps


def errors_of_curves(make_method: MakeMethod, quick: bool, report: Report) -> list[dict[str, Any]]:
    """Both errors of V4 over n for each number of steps; over h those of 10 steps (H fig. 2.9), and
    for 100 steps those of the curve and of the angular momentum along it (H fig. 2.11)."""
    table, common = oracles("oracles", STEP * STEPS, STEPS), (make_method, report)
    for steps in FLOORS:
        cases = [Case(n, STEP, steps) for n in range(12, 51, 2 if quick else 1)]
        table += refine(IN_N % steps, problem(), KEPLER, cases, ENDS_AND_CURVE, *common)
    for steps, quantities in IN_H.items():
        cases = in_as_many_steps(NS, steps, quick)
        table += refine(fixed_number(steps), problem(), KEPLER, cases, quantities, *common)
    return table


def bases_and_orders(table: DataFrame) -> dict[str, Measurement]:
    """Bases in n of the step ends' error over the curve's, which are 1 if both converge at one
    rate, with the slowest convergence of polynomials over the steps on the orbit; and orders in
    h."""
    numbers: dict[str, Measurement] = {"apart": number(table, quantity=ORACLES)}
    base, plain_bases = "base of the step ends' error over the curve's", []
    for steps, floor in FLOORS.items():
        n, ends, over = _errors_above_round_off(table, "n", floor, study=IN_N % steps)
        fit = partial(convergence_fits.geometric, n, over, floor=0.0, ceiling=0.5)
        plain_bases.append(estimate(fit()))
        numbers[f"{base}, {steps} steps"] = fit(power=(-POWER[0], 0.0))
        starts = [math.remainder(k * STEP, 2.0 * math.pi) for k in range(steps)]
        slowest = max(convergence_of_polynomials(start, STEP) for start in starts)
        numbers[f"slowest_{steps}"] = slowest
    early = (n < FROM) & (ends < 0.1)
    numbers[f"{base} before n = {FROM}, {steps} steps"] = convergence_fits.geometric(
        n[early], over[early], floor=0.0, ceiling=2.0
    )
    numbers[f"{base}, nearest to 1 over the numbers of steps"] = max(
        plain_bases, key=_unknown_or_largest
    )
    numbers["plain"] = slowest * math.exp(POWER[0] / FROM)
    curve_over_ends, gains = [], []
    for n in NS:
        *_, over = _errors_above_round_off(table, "step", IN_H_FLOOR, study=fixed_number(10), n=n)
        curve_over_ends.append(readings.largest(1.0 / over))
        where: Any = {"study": fixed_number(STEPS), "n": n}
        orders = (readings.order(table, IN_H_FLOOR, quantity=name, **where) for name in IN_H[STEPS])
        curve, momentum = map(estimate, orders)
        lost = curve.refuted or momentum.refuted
        gains.append(Estimate(momentum.value - curve.value, refuted=lost))
    return numbers | {
        "largest curve error over that of step ends in h-refinement, least over n": (
            readings.smallest(np.array(curve_over_ends))
        ),
        "order of the angular momentum's error along the curve over the curve's own, largest over "
        "n": max(gains, key=_unknown_or_largest),
    }


def _unknown_or_largest(fitted: Estimate) -> tuple[bool, float]:
    """A key for `max` that prefers an estimate that is refuted or NaN, else the largest one."""
    return fitted.refuted or math.isnan(fitted.value), fitted.value


def _errors_above_round_off(
    table: DataFrame, by: str, floor: float, **where: Any
) -> tuple[Any, Any, Any]:
    """(n or step, error at step ends, that error over the curve's), above round-off."""
    (x, ends), (_, curve) = (
        series(table, by, quantity=quantity, **where) for quantity in ENDS_AND_CURVE
    )
    above = ~(ends <= 10.0 * floor)
    return x[above], ends[above], ends[above] / curve[above]
