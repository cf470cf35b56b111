"""L7: the 3D pendulum near its equilibrium, order under h-refinement (H figure 3.6)."""

from __future__ import annotations

import galvi
from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    DataFrame,
    Fit,
    MakeMethod,
    Report,
    at_fixed_time,
    method_on_group,
    readings,
    refine,
    table_of,
)
from benchmarks.claims.lie_groups.free_body import OTHER_MOTIONS
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH

NS = (3, 4, 5, 6)
FLOOR = 2e-14  # entries of R; 1.2e-14 was measured after 256 steps
FIXED_TIME = "h-refinement, T = 5"
FAULTS = OTHER_MOTIONS


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 5' of the one-step and the curve error for n = 3 to 6."""
    counts = [round(2.0 ** (j / 4)) for j in range(10, 28 if quick else 31)]
    cases = at_fixed_time(NS, 5.0, counts)
    options = (cases, ENDS_AND_CURVE, make_method, report, method_on_group)
    return table_of(refine(FIXED_TIME, galvi.problems.pendulum_3d(), TRUTH, *options))


def read(table: DataFrame) -> dict[str, Fit]:
    """The orders of step ends and of the curve."""
    return {
        f"order of the {quantity}, n = {n}": readings.order(table, FLOOR, quantity=quantity, n=n)
        for quantity in ENDS_AND_CURVE
        for n in NS
    }
