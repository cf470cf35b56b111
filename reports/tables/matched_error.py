"""Ratios of times at matched error."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.dependable import bounds, resolution
from benchmarks.work_precision.fronts import NOT_REACHED, OURS, at_smallest, ratios
from benchmarks.work_precision.problem import ATTITUDE
from reports.tables.number_format import TIMES, known, readable, seconds

ERRORS = (1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 5e-11, 1e-11, 1e-12)
OF_ATTITUDES = (1e-2, 1e-4, 7e-6, 1e-6, 1e-8, 1e-9, 1e-10, 2e-11, 1e-11, 1e-12, 1e-13)
SMALLEST = "its smallest error"
OURS_BEGIN = "galvi"


def is_ours(contender: str) -> bool:
    """Whether this is one of galvi's own methods."""
    return contender.startswith(OURS_BEGIN)


def errors_of(runs: pd.DataFrame) -> tuple[float, ...]:
    """The errors at which one problem's contenders are compared, by the quantity that has them;
    none that its truth cannot tell."""
    errors = OF_ATTITUDES if (runs["quantity"] == ATTITUDE).all() else ERRORS
    least = resolution(runs)
    return tuple(error for error in errors if error >= least)


def matched(frame: pd.DataFrame) -> pd.DataFrame:
    """problem, contender, error, seconds, ratio; see `benchmarks.work_precision.fronts.ratios`."""
    found = [ratios(runs, errors_of(runs)) for _, runs in frame.groupby("problem", sort=False)]
    return pd.concat(found, ignore_index=True) if found else ratios(frame, ())


def smallest(frame: pd.DataFrame) -> pd.DataFrame:
    """The same at the smallest error of each contender, and whether that is a `bound` alone; see
    `benchmarks.work_precision.fronts.at_smallest`."""
    ends = at_smallest(frame)
    return ends.assign(bound=bounds(ends, frame))


def readable_ratios(table: pd.DataFrame, ends: pd.DataFrame, problem: str) -> pd.DataFrame:
    """A line for each contender, a column for each error: ratio and time, or "not reached".

    A time of the run that is the reference is marked, as its error is unknown. The last column,
    from `smallest`, is at the contender's own smallest error, with ≤ where that is a bound.
    """
    rows = table[table["problem"] == problem]
    own = ends[ends["problem"] == problem].set_index("contender") if len(ends) else ends
    lines = []
    for contender, times in rows.groupby("contender", sort=False):
        line = {"contender": contender}
        end = own.loc[contender] if contender in own.index else None
        for _, seen in times.iterrows():
            unknown = known(seen["seconds"]) and (end is None or end["error"] > seen["error"])
            said = _cell(seen, str(contender))
            line[heading(seen["error"])] = f"reference: {said}" if unknown else said
        if end is not None:
            error = f"{'≤ ' * bool(end['bound'])}{readable(end['error'], 2)}"
            line[SMALLEST] = f"{error}: {_cell(end, str(contender))}"
        lines.append(line)
    return pd.DataFrame(lines).fillna("")


def heading(error: float) -> str:
    """The heading of an error's column, e.g. 10⁻⁶."""
    return readable(error, 1).removeprefix("1·")


def fastest_cells(table: pd.DataFrame, problem: str) -> list[tuple[int, str]]:
    """(line, column) of the least time in each column of `readable_ratios`."""
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
