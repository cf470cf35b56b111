"""Changes of level that are known, with their reason: rows of known_changes.csv."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

FILE = Path(__file__).with_suffix(".csv")
COLUMNS = ("benchmark", "quantity", "commit", "reason")
FEWEST = 7  # digits of a commit


@dataclass(frozen=True)
class KnownChange:
    """A change near a commit that has a reason; benchmark: part of its name, "" for all."""

    benchmark: str
    quantity: str
    commit: str
    reason: str

    def fits(self, benchmark: str, quantity: str, commit: str) -> bool:
        """Whether it explains this change."""
        alike = self.benchmark in benchmark and self.quantity == quantity
        return alike and commit.startswith(self.commit)


def known_changes(file: Path = FILE) -> tuple[KnownChange, ...]:
    """The rows of the file. Raises ValueError for a row without a reason or a full commit."""
    table = pd.read_csv(file, dtype=str, keep_default_na=False)
    if tuple(table) != COLUMNS:
        raise ValueError(f"{file.name} must have the columns {', '.join(COLUMNS)}.")
    found = tuple(KnownChange(**row) for row in table.to_dict("records"))  # type: ignore[misc]
    for one in found:
        if not one.reason.strip() or len(one.commit) < FEWEST:
            raise ValueError(
                f"{file.name}: a change needs a reason and at least {FEWEST} digits of its commit; "
                f"received {one}."
            )
    return found


def reason_of(known: Sequence[KnownChange], benchmark: str, quantity: str, commit: str) -> str:
    """Why a change is known; "" when it is not."""
    return next((one.reason for one in known if one.fits(benchmark, quantity, commit)), "")
