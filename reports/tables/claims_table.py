"""The rows of the claims, as in claims.csv and as readable text."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from benchmarks.checks.claim import Row
from reports.tables.number_format import plain

COLUMNS = (
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
)
READ = ("id", "quantity", "claimed", "measured", "uncertainty", "slack", "expected", "verdict")


def claims_frame(rows: Iterable[Row]) -> pd.DataFrame:
    """One line for each row; missing values are empty."""
    frame = pd.DataFrame([{name: getattr(row, name) for name in COLUMNS} for row in rows])
    frame = frame.reindex(columns=list(COLUMNS))
    for name in ("measured", "uncertainty", "slack"):
        frame[name] = pd.to_numeric(frame[name])
    return frame


def readable_claims(rows: Iterable[Row] | pd.DataFrame) -> pd.DataFrame:
    """The columns that fit on a page, as text; accepts rows or their frame."""
    table = rows if isinstance(rows, pd.DataFrame) else claims_frame(rows)
    frame = table[list(READ)]
    return frame.assign(
        measured=[plain(number) for number in frame["measured"]],
        uncertainty=[plain(number, 2) for number in frame["uncertainty"]],
        slack=[plain(number, 2) for number in frame["slack"]],
    )
