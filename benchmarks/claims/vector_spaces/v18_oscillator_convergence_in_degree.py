"""V18: the harmonic oscillator, exponential convergence with N (M 6.1, figure 1 right)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.oscillator import (
    DURATION,
    FLOOR,
    LARGEST,
    METHOD,
    OSCILLATION,
    QUANTITY,
    TRUTH,
    refinement,
)

STUDIES = {f"N-refinement, h = {h:g}": h for h in (LARGEST, DURATION)}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'N-refinement, h = 0.8', M's largest step, and '..., h = 8', a single one."""
    rows = []
    for name, h in STUDIES.items():
        cases = [Case(n, h, round(DURATION / h)) for n in range(2, 9 if h == LARGEST else 19)]
        rows += refinement(name, cases, make_method, report)
    return frame(rows)


def judge(table: DataFrame) -> list[Row]:
    """Errors decay geometrically in N, and not more slowly for larger N."""
    return [
        V18.row(
            f"base of the error, h = {h:g}",
            Geometric(),
            readings.decay(table, FLOOR, study=name, quantity=QUANTITY),
            setup=f"{OSCILLATION}; {METHOD}; T = {DURATION:g}, h = {h:g}",
        )
        for name, h in STUDIES.items()
    ]


V18 = Claim(
    "V18",
    "Oscillator: exponential convergence in N",
    study,
    judge,
    ("M fig. 1 right",),
    source="M 6.1, fig. 1 right",
    claimed="exponential convergence with respect to the polynomial order",
    reason="cos t has no singularity: the factor itself falls with N. M names no h; these are its "
    "largest step and a single one to its T.",
    reference=f"{TRUTH.name}; SciPy DOP853 (A9)",
    statement="M 6.1, fig. 1 right: errors fall exponentially with the degree N.",
    caught=(of_table("base of the error, h = 0.8", "base of the error, h = 8", beta=1.0 + 1e-6),),
)
