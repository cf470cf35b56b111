"""What the number of bodies costs at matched error, as text for the page."""

from __future__ import annotations

import pandas as pd

from reports.tables.matched_error import is_ours
from reports.tables.number_format import TIMES, known, readable, seconds

NOBODY = "not reached"


def scaling_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each number of bodies, and how to set the columns.

    Of each contender the setting that stands for it, its time for an orbit of the innermost planet,
    and that time as a multiple of the first galvi method's.
    """
    contenders = list(frame["contender"].drop_duplicates())
    ours = next((name for name in contenders if is_ours(name)), None)
    lines = []
    for bodies, rows in frame.groupby("bodies", sort=True):
        chosen = {row["contender"]: row for _, row in rows[rows["matched"]].iterrows()}
        least = chosen[ours]["seconds_per_orbit"] if ours in chosen else float("nan")
        line = {"bodies": str(bodies)}
        for name in contenders:
            line[name] = _cell(chosen.get(name), least, name == ours) or _why(
                rows[rows["contender"] == name]
            )
        if ours in chosen:
            line["pairs a second"] = readable(chosen[ours]["pairs_per_second"])
            line["share of the limit"] = readable(chosen[ours]["share"], 2)
        lines.append(line)
    table = pd.DataFrame(lines).fillna("")
    return table, dict.fromkeys(table.columns, "number")


def _cell(row: pd.Series | None, least: float, is_measure: bool) -> str:
    if row is None:
        return ""
    time = f"{seconds(row['seconds_per_orbit'])} ({row['settings']})"
    ratio = row["seconds_per_orbit"] / least
    return time if is_measure or not known(ratio) else f"{readable(ratio, 2)}{TIMES}, {time}"


def _why(rows: pd.DataFrame) -> str:
    """Of a contender without a run that stands for it: what its runs say when all of them failed,
    nothing when it did not take part."""
    if rows.empty:
        return ""
    failed = rows["error"].isna() & (rows["status"] != "")
    return str(rows["status"].iloc[0]) if failed.all() else NOBODY
