"""L2: the free rigid body, n-refinement (H figure 3.1)."""

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
    number,
    readings,
    refine,
    table_of,
    times,
)
from benchmarks.claims.lie_groups.curves_and_ends import CURVE, ENDS, n_stars, scan, scan_of
from benchmarks.claims.lie_groups.free_body import FLOOR, METHODS, OTHER_MOTIONS
from benchmarks.claims.lie_groups.pendulum_motion import oracles
from references.closed_forms.top_motion import FREE_TOP

# Chart -> smallest n at which the curve's own error exceeds that of its ends:
FROM = {"Cayley": 7, "exponential": 5, "modified Rodrigues": 5}
FAULTS = {
    **OTHER_MOTIONS,
    "curves of T = 500 that are worse": Fault(
        table=times(1.9, study=scan_of(500.0), quantity=CURVE)
    ),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement, Cayley' and so on of the one-step and the curve error up to T = 5; the
    scan of T; and the distance of two oracles."""
    body = galvi.problems.free_rigid_body()
    cases = [Case(n, 0.5, 10) for n in range(3, 16)]
    rows = [*scan(body, make_method, report), oracles(body, 500.0, 100, second=FREE_TOP)]
    for chart, method in METHODS.items():
        options = (make_method, report, method)
        rows += refine(f"n-refinement, {chart}", body, FREE_TOP, cases, ENDS_AND_CURVE, *options)
    return table_of(rows)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The decay of both errors, single errors at step ends with their ratios, and n*."""
    numbers = n_stars(table) | {ORACLES: number(table, quantity=ORACLES)}
    for chart, since in FROM.items():
        series = table[table["study"] == f"n-refinement, {chart}"]
        curve = readings.decay(series, FLOOR, since, quantity=CURVE)
        numbers[f"base of the {CURVE}, {chart} chart"] = curve
        numbers[f"base of the {ENDS}, {chart} chart"] = readings.decay(series, FLOOR, quantity=ENDS)
        numbers[f"{ENDS}, n = 12, {chart} chart"] = number(series, quantity=ENDS, n=12)
    sixth = {
        chart: number(table, study=f"n-refinement, {chart}", quantity=ENDS, n=6) for chart in FROM
    }
    for chart in ("exponential", "modified Rodrigues"):
        ratio = sixth[chart] / sixth["Cayley"]
        numbers[f"{ENDS} over that with Cayley, n = 6, {chart} chart"] = ratio
    return numbers
