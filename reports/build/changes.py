"""Differences from the previous rows: verdicts, and values moved beyond their uncertainty."""

from __future__ import annotations

import math

import pandas as pd

from reports.tables.number_format import known, plain

SIGMAS = 2.0
WITHOUT = 0.1  # relative tolerance of a value without uncertainty: round-off differs by machine
COLUMNS = ["claim", "quantity", "what", "before", "now"]


def changes(before: pd.DataFrame | None, now: pd.DataFrame) -> pd.DataFrame:
    """What changed since earlier rows of the same claims and setting, with COLUMNS, as text.

    A number moved when it differs by more than 2 standard errors of the difference, or, where
    neither row has an uncertainty, by more than a tenth.
    """
    if before is None:
        return pd.DataFrame(columns=COLUMNS)
    alike = before["id"].isin(now["id"]) & before["setting"].isin(now["setting"])
    old_rows, new_rows, lines = _by_check(before[alike]), _by_check(now), []
    for check, new in new_rows.items():
        old = old_rows.get(check)
        if old is None:
            lines += [(*check, "new", "", f"{new['verdict']}, {_number(new)}")] * bool(old_rows)
            continue
        if old["verdict"] != new["verdict"]:
            lines.append((*check, "verdict", old["verdict"], new["verdict"]))
        if moved(old["measured"], old["uncertainty"], new["measured"], new["uncertainty"]):
            lines.append((*check, "measured", _number(old), _number(new)))
    gone = [check for check in old_rows if check not in new_rows]
    lines += [(*check, "gone", old_rows[check]["verdict"], "") for check in gone]
    return pd.DataFrame(lines, columns=COLUMNS)


def _by_check(rows: pd.DataFrame) -> dict[tuple[str, str], pd.Series]:
    return {(row["id"], row["quantity"]): row for _, row in rows.iterrows()}


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
