"""V5: the Kepler problem, invariants along the curve under n-refinement (H figures 2.7, 2.8)."""

from __future__ import annotations

from benchmarks.claims.kit import DataFrame, MakeMethod, Measurement, Report, readings, table_of
from benchmarks.claims.vector_spaces.kepler_orbit import FLOOR, IN_N, INVARIANTS, n_refinement


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the relative errors of energy and angular momentum from (q, q')."""
    ns = range(8, 57, 3) if quick else range(7, 61)
    return table_of(n_refinement(ns, INVARIANTS, make_method, report))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The fitted bases."""
    return {
        f"base of the {quantity}": readings.base(table, FLOOR, study=IN_N, quantity=quantity)
        for quantity in INVARIANTS
    }
