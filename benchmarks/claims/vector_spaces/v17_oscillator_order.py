"""V17: the harmonic oscillator, order 2 N under h-refinement (M 6.1, figure 1 left)."""

from __future__ import annotations

from benchmarks.claims.kit import (
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    at_fixed_time,
    readings,
    table_of,
)
from benchmarks.claims.vector_spaces.oscillator import DURATION, FLOOR, QUANTITY, refinement

DEGREES = (1, 2, 3, 4, 5)
STUDY = "h-refinement, T = 8"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 8' for N = 1 to 5; the numbers of steps, M's among them, have the
    ratio 2^(1/4)."""
    counts = [round(10 * 2.0 ** (j / 4)) for j in range(21 if quick else 33)]
    cases = at_fixed_time([N + 1 for N in DEGREES], DURATION, counts)
    return table_of(refinement(STUDY, cases, make_method, report))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The order of each degree, once to compare with M's measurement and once with its theory."""
    return {
        f"order of the error, N = {N}{claim}": readings.order(
            table, FLOOR, study=STUDY, quantity=QUANTITY, n=N + 1
        )
        for N in DEGREES
        for claim in ("", ", against the theory")
    }
