"""The rows of the claims, as in claims.csv, and the fits that the convergence figures show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd

from benchmarks.checks.claim import Row
from reports.results.claim_results import ClaimResult, first_measured
from reports.results.section import Figure

ROW_COLUMNS = (
    "id",
    "quantity",
    "source",
    "setup",
    "claimed",
    "bound",
    "measured",
    "uncertainty",
    "expected",
    "reference",
    "verdict",
    "reason",
    "slack",
    "slopes",
    "misses",
    "absent",
)
NUMBER_COLUMNS = ("measured", "uncertainty", "slack", "misses")
FIT_COLUMNS = (
    *("claim", "source", "study", "quantity", "n", "rate", "measured", "uncertainty", "claimed"),
    *("first", "last", "points"),
)
READABLE_COLUMNS = (
    "id",
    "quantity",
    "claimed",
    "measured",
    "uncertainty",
    "slopes",
    "slack",
    "expected",
    "verdict",
)


def claims_frame(rows: Iterable[Row]) -> pd.DataFrame:
    """A table with a line for each row, with columns ROW_COLUMNS; missing numbers are NaN."""
    table = pd.DataFrame(list(rows), columns=list(ROW_COLUMNS))
    table[list(NUMBER_COLUMNS)] = table[list(NUMBER_COLUMNS)].apply(pd.to_numeric)
    return table


RATE_TEXTS = {"geometric": "base of n", "algebraic": "power of h"}


def convergence_frame(checked: Sequence[ClaimResult], figures: Sequence[Figure]) -> pd.DataFrame:
    """A line for each fitted series; `first` and `last` are the ends of the fit's window."""
    lines = []
    for figure in figures:
        source = first_measured(checked, figure.claims)
        if source is None:
            continue
        for rate in figure.options.get("rates", ()):
            fit = rate.fit(source.table)
            lines.append(
                {
                    "claim": source.claim.id,
                    "source": figure.source,
                    "study": rate.study,
                    "quantity": rate.quantity,
                    "n": rate.n,
                    "rate": RATE_TEXTS[fit.kind],
                    "measured": fit.rate,
                    "uncertainty": fit.uncertainty,
                    "claimed": rate.claimed,
                    "first": fit.window[0],
                    "last": fit.window[1],
                    "points": fit.points,
                }
            )
    return pd.DataFrame(lines, columns=list(FIT_COLUMNS))
