"""V5: the Kepler problem, invariants along the curve under n-refinement (H figures 2.7, 2.8)."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.claims.vector_spaces.kepler_orbit import FLOOR, SETUP, THEORY, n_refinement
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import series

CLAIMED, RESOLUTION = 0.74, 0.005
SOURCES = {
    "energy error along the curve": ("H fig. 2.7", "exact energy -1/2"),
    "angular momentum error along the curve": ("H fig. 2.8", "exact angular momentum 0.8"),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series 'n-refinement' of the relative errors of energy and angular momentum from (q, q')."""
    ns = range(8, 57, 3) if quick else range(7, 61)
    return n_refinement(ns, tuple(SOURCES), make_method, report)


def judge(table: pd.DataFrame) -> list[Row]:
    """Compare each fitted base with 0.74."""
    rows = []
    for quantity, (source, exact) in SOURCES.items():
        n, errors = series(table, "n", study="n-refinement", quantity=quantity)
        fit = convergence_fits.geometric(n, errors, floor=FLOOR)
        rows.append(
            Row(
                id="V5",
                quantity=f"base of the {quantity}",
                source=source,
                setup=f"{SETUP}; relative, from (q, q') at 20 times a step",
                claimed="O(0.74^n)",
                bound=f"base {CLAIMED} -+ {RESOLUTION} (as printed) -+ 2 standard errors",
                measured=fit.rate,
                uncertainty=fit.uncertainty,
                expected=bounds.HOLDS,
                reason=f"{THEORY}; invariants from (q, q') see the curve's own error, and that of "
                "q' carries hardly any algebraic factor.",
                reference=exact,
                verdict=bounds.base(fit, CLAIMED, RESOLUTION),
            )
        )
    return rows


V5 = Claim(
    "V5",
    "Kepler at h = 2: energy and angular momentum along the curve O(0.74^n)",
    study,
    judge,
    ("H fig. 2.7", "H fig. 2.8"),
)
