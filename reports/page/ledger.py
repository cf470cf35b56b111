"""The page of the papers' statements."""

from __future__ import annotations

from typing import Any

import pandas as pd

from benchmarks.claims.statements import EFFECTS, FALSE, STATUSES, counted, statements
from reports.page.grid import grid

PAPERS = ("H", "M")


def ledger() -> dict[str, Any]:
    """What the template needs: all statements, those that are false as printed, and counts."""
    found = statements()
    counts = pd.DataFrame(
        [
            [status, *(sum(one.status == status and one.where[0] == paper for one in found)
                       for paper in PAPERS)]
            for status in STATUSES
        ],
        columns=["status", *PAPERS],
    )  # fmt: skip
    return {
        "headline": counted(found),
        "all": found,
        "misprints": [one for one in found if one.status == FALSE],
        "effects": EFFECTS.items(),
        "statuses": list(STATUSES),
        "counts": grid(counts, dict.fromkeys(PAPERS, "number")),
    }
