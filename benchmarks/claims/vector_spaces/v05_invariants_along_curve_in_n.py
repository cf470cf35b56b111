"""V5: the Kepler problem, invariants along the curve under n-refinement (H figures 2.7, 2.8)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.kepler_orbit import FLOOR, SETUP, THEORY, n_refinement

CLAIMED, RESOLUTION = 0.74, 0.005
SOURCES = {
    "energy error along the curve": ("H fig. 2.7", "exact energy -1/2"),
    "angular momentum error along the curve": ("H fig. 2.8", "exact angular momentum 0.8"),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the relative errors of energy and angular momentum from (q, q')."""
    ns = range(8, 57, 3) if quick else range(7, 61)
    return n_refinement(ns, tuple(SOURCES), make_method, report)


def judge(table: DataFrame) -> list[Row]:
    """Compare each fitted base with 0.74."""
    return [
        V5.row(
            f"base of the {quantity}",
            Base(CLAIMED, RESOLUTION),
            readings.base(table, FLOOR, study="n-refinement", quantity=quantity),
            source=source,
            reference=exact,
        )
        for quantity, (source, exact) in SOURCES.items()
    ]


V5 = Claim(
    "V5",
    "Kepler at h = 2: energy and angular momentum along the curve O(0.74^n)",
    study,
    judge,
    ("H fig. 2.7", "H fig. 2.8"),
    setup=f"{SETUP}; relative, from (q, q') at 20 times a step",
    claimed="O(0.74^n)",
    reason=f"{THEORY}; invariants from (q, q') see the curve's own error, and that of q' carries "
    "hardly any algebraic factor.",
    statement="H fig. 2.7, 2.8: the errors of energy and angular momentum along the curve are "
    "O(0.74^n).",
    caught=(
        of_table(
            *(
                f"base of the {what} error along the curve"
                for what in ("energy", "angular momentum")
            ),
            C=1.0 + 1e-4,
        ),
    ),
)
