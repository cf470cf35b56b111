"""Differences from the previous rows: verdicts, and values moved beyond their uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pandas as pd

from reports.tables.number_format import known, plain

SIGMAS = 2.0
WITHOUT = 0.1  # relative tolerance of a value without uncertainty: round-off differs by machine


@dataclass(frozen=True)
class Change:
    """A row that changed; before and now are text."""

    id: str
    quantity: str
    what: str
    before: str
    now: str


def changes(before: pd.DataFrame | None, now: pd.DataFrame) -> list[Change]:
    """Compare rows with earlier ones of the same id, quantity and setting; list added and removed.

    A number moved when it differs by more than 2 standard errors of the difference, or, where
    neither row has an uncertainty, by more than a tenth.
    """
    if before is None or now.empty:
        return []
    before = before[before["id"].isin(set(now["id"]))]
    alike = before[before["setting"].isin(set(now["setting"]))]
    old = {(row["id"], row["quantity"]): row for _, row in alike.iterrows()}
    found, seen = [], set()
    for _, row in now.iterrows():
        place = (row["id"], row["quantity"])
        seen.add(place)
        if place in old:
            found += _differences(place, old[place], row)
        elif len(alike):
            found.append(Change(*place, "new", "", f"{row['verdict']}, {_number(row)}"))
    gone = [place for place in old if place not in seen]
    return found + [Change(*place, "gone", old[place]["verdict"], "") for place in gone]


def _differences(place: tuple[str, str], old: pd.Series, new: pd.Series) -> list[Change]:
    found = []
    if old["verdict"] != new["verdict"]:
        found.append(Change(*place, "verdict", old["verdict"], new["verdict"]))
    if moved(*(row[name] for row in (old, new) for name in ("measured", "uncertainty"))):
        found.append(Change(*place, "measured", _number(old), _number(new)))
    return found


def moved(old: float, old_error: float, new: float, new_error: float) -> bool:
    """Whether two numbers differ by more than their uncertainties, NaN or None where unknown."""
    if not (known(old) and known(new)):
        return known(old) != known(new)
    errors = [error for error in (old_error, new_error) if known(error)]
    allowed = SIGMAS * math.hypot(*errors) if errors else WITHOUT * max(abs(old), abs(new))
    return abs(new - old) > allowed


def _number(row: pd.Series) -> str:
    measured, error = plain(row["measured"], 4), plain(row["uncertainty"], 2)
    return f"{measured} -+ {error}" if measured and error else measured or "no number"
