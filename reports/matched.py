"""Times at matched error: who is how much faster."""

from __future__ import annotations

import pandas as pd

from benchmarks.fronts import NOT_REACHED, OURS, ratios
from reports.numerals import TIMES, known, readable, seconds

TARGETS = (1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
OURS_BEGIN = "galvi"


def is_ours(contender: str) -> bool:
    """Whether this is one of galvi's own methods."""
    return contender.startswith(OURS_BEGIN)


def matched(frame: pd.DataFrame) -> pd.DataFrame:
    """problem, contender, error, seconds, ratio; see `benchmarks.fronts.ratios`."""
    return ratios(frame, TARGETS)


def readable_ratios(table: pd.DataFrame, problem: str) -> pd.DataFrame:
    """A line for each contender, a column for each error: ratio and time, or "not reached"."""
    rows = table[table["problem"] == problem]
    lines = []
    for contender, times in rows.groupby("contender", sort=False):
        line = {"contender": contender}
        for _, seen in times.iterrows():
            line[heading(seen["error"])] = _cell(seen, str(contender))
        lines.append(line)
    return pd.DataFrame(lines)


def heading(error: float) -> str:
    """Of a column: the error asked for, e.g. 10⁻⁶."""
    return readable(error, 1).removeprefix("1·")


def fastest_cells(table: pd.DataFrame, problem: str) -> list[tuple[int, str]]:
    """Of `readable_ratios`: line and column of the least time in each column."""
    rows = table[table["problem"] == problem]
    lines = list(rows["contender"].drop_duplicates())
    times = rows[(rows["contender"] != OURS) & rows["seconds"].notna()]
    least = times.loc[times.groupby("error")["seconds"].idxmin()]
    return [(lines.index(row["contender"]), heading(row["error"])) for _, row in least.iterrows()]


def _cell(row: pd.Series, contender: str) -> str:
    if not known(row["seconds"]):
        return NOT_REACHED
    if contender == OURS:
        return seconds(row["seconds"])
    if not known(row["ratio"]):
        return f"{seconds(row['seconds'])} ({row['ratio']})"
    return f"{readable(row['ratio'], 2)}{TIMES} ({seconds(row['seconds'])})"
