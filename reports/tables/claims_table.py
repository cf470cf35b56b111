"""The rows of the claims, as in claims.csv and as readable text."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from benchmarks.checks.claim import Row

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
    "slopes",
    "misses",
    "absent",
)
NUMBERS = ("measured", "uncertainty", "slack", "misses")
READ = ("id", "quantity", "claimed", "measured", "uncertainty", "slopes", "slack", "expected",
        "verdict")  # fmt: skip


def claims_frame(rows: Iterable[Row]) -> pd.DataFrame:
    """One line for each row; missing values are empty."""
    frame = pd.DataFrame([{name: getattr(row, name) for name in COLUMNS} for row in rows])
    frame = frame.reindex(columns=list(COLUMNS))
    for name in NUMBERS:
        frame[name] = pd.to_numeric(frame[name])
    return frame
