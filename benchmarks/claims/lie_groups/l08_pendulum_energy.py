"""L8: the 3D pendulum near its equilibrium, energy over 5000 long steps (H figure 3.7)."""

from __future__ import annotations

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    at_fixed_time,
    method_on_group,
    number,
    readings,
    refine,
    table_of,
)
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH, oracles
from benchmarks.claims.short_runs import SHORT, STARTS, short_runs
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import history

N, STEP, STEPS = 8, 1.5, 5000
QUANTITY = "energy error"
FLOOR = 5e-15  # round-off; 1e-15 was measured at h = 0.375


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of the relative energy error at step ends, from (R, p); 'h-refinement' of
    its largest value in the time 300, some 70 swings, with 200 steps of 1.5 and more; short runs
    from 64 states of the motion; and the distance of two oracles."""
    pendulum = galvi.problems.pendulum_3d()
    measures = {QUANTITY: energy_errors}
    case = Case(N, STEP, STEPS)
    rows = history("history", pendulum, case, measures, make_method, method_on_group)
    cases = at_fixed_time([N], 300.0, (200, 238, 283, 336, 400, 476, 566))
    options = (cases, [QUANTITY], make_method, report, method_on_group)
    rows += refine("h-refinement", pendulum, TRUTH, *options)
    method = method_on_group(make_method, N)
    rows += short_runs(QUANTITY, pendulum, TRUTH, 300.0, method, STEP)
    return table_of([*rows, oracles(pendulum, 300.0, STARTS)])


def read(table: DataFrame) -> dict[str, Measurement]:
    """The drift, its limit, and the order of the largest error."""
    order = readings.order(table, FLOOR, study="h-refinement")
    return {
        f"{QUANTITY}, n = {N}": readings.drift(table, study="history"),
        "limit": readings.largest_of(table, study=SHORT),
        f"order of the largest {QUANTITY}, n = {N}": order,
        ORACLES: number(table, quantity=ORACLES),
    }
