"""The table of the fits shown in the convergence figures."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from reports.results.claim_results import ClaimResult, first_measured
from reports.results.section import Figure

COLUMNS = (
    "claim",
    "source",
    "study",
    "quantity",
    "n",
    "rate",
    "measured",
    "uncertainty",
    "claimed",
    "first",
    "last",
    "points",
)
MEANING = {"geometric": "base of n", "algebraic": "power of h"}


def convergence_frame(checked: Sequence[ClaimResult], figures: Sequence[Figure]) -> pd.DataFrame:
    """One line for each fitted series; first and last are the n or h of the fit's window."""
    lines = []
    for figure in figures:
        source = first_measured(checked, figure.claims)
        if source is None:
            continue
        for rate in figure.options.get("rates", ()):
            fit = rate.fit(source.frame)
            lines.append(
                {
                    "claim": source.claim.id,
                    "source": figure.source,
                    "study": rate.study,
                    "quantity": rate.quantity,
                    "n": rate.n,
                    "rate": MEANING[fit.kind],
                    "measured": fit.rate,
                    "uncertainty": fit.uncertainty,
                    "claimed": rate.claimed,
                    "first": fit.window[0],
                    "last": fit.window[1],
                    "points": fit.points,
                }
            )
    return pd.DataFrame(lines, columns=list(COLUMNS))
