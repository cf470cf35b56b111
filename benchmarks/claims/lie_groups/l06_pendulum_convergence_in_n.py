"""L6: the 3D pendulum near its equilibrium, n-refinement (H figure 3.5)."""

from __future__ import annotations

import galvi
from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    ORACLES,
    Case,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    method_on_group,
    number,
    readings,
    refine,
    table_of,
    times,
)
from benchmarks.claims.lie_groups.curves_and_ends import CURVE, n_stars, scan, scan_of
from benchmarks.claims.lie_groups.free_body import OTHER_MOTIONS
from benchmarks.claims.lie_groups.pendulum_motion import FLOOR, TRUTH, oracles

# To n = 5 this small swing is nearly a sum of sines, entire functions, for which errors fall faster
# than geometrically: of one a hundredth as large by 75, 150, 340, 440 and 1300 times from n = 2 on.
# The rate that is left is slower, and a window from n = 2 would see it as an end of the decay.
FROM = 4
WEIGHTS = {"light": 9.81, "heavy": 22.0}  # H prints no m g; its figures 3.8 and 3.9 fit 22
FAULTS = {
    **OTHER_MOTIONS,
    "curves of T = 500 that are worse": Fault(
        table=times(1.9, study=scan_of(500.0, "m g = 22, "), quantity=CURVE)
    ),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error to T = 5; the scan of T."""
    pendulum = galvi.problems.pendulum_3d()
    cases = [Case(n, 0.5, 10) for n in range(2, 15 if quick else 19)]
    options = (make_method, report, method_on_group)
    rows = refine("n-refinement", pendulum, TRUTH, cases, ENDS_AND_CURVE, *options)
    for weight in WEIGHTS.values():
        heavy = galvi.problems.pendulum_3d(weight)
        rows += scan(heavy, make_method, report, f"m g = {weight:g}, ")
    return table_of([*rows, oracles(pendulum, 50.0, 100)])


def read(table: DataFrame) -> dict[str, Measurement]:
    """The decay and the smallest value of both errors, and n*."""
    numbers: dict[str, Measurement] = {ORACLES: number(table, quantity=ORACLES)}
    for key, weight in WEIGHTS.items():
        numbers |= n_stars(table, f"m g = {weight:g}, ", key)
    for quantity in ENDS_AND_CURVE:
        decay = readings.decay(table, FLOOR, FROM, study="n-refinement", quantity=quantity)
        numbers |= {f"base of the {quantity}": decay, f"smallest {quantity}": decay.smallest}
    return numbers
