"""V18: the harmonic oscillator, exponential convergence with N (M 6.1, figure 1 right)."""

from __future__ import annotations

from benchmarks.claims.kit import (
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    readings,
    table_of,
)
from benchmarks.claims.vector_spaces.oscillator import (
    DURATION,
    FLOOR,
    LARGEST,
    QUANTITY,
    refinement,
)

STUDIES = {f"N-refinement, h = {h:g}": h for h in (LARGEST, DURATION)}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'N-refinement, h = 0.8', M's largest step, and '..., h = 8', a single one."""
    rows = []
    for name, h in STUDIES.items():
        cases = [Case(n, h, round(DURATION / h)) for n in range(2, 9 if h == LARGEST else 19)]
        rows += refinement(name, cases, make_method, report)
    return table_of(rows)


def read(table: DataFrame) -> dict[str, Measurement]:
    """The decay of both series."""
    return {
        f"base of the error, h = {h:g}": readings.decay(table, FLOOR, study=name, quantity=QUANTITY)
        for name, h in STUDIES.items()
    }
