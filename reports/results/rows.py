"""Tables of rows that earlier commands wrote: read, marked with their origin, and merged."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path

import pandas as pd

from benchmarks.store.cells import read_csv

MARKS = ("date", "commit", "setting")  # origin of a row; setting: quick or default
TEXTS = (  # columns of texts, also where all of them are empty
    *MARKS,
    *("study", "quantity", "label", "status", "absent"),  # of studies
    *("source", "setup", "claimed", "bound", "expected", "reference", "verdict", "reason"),
    *("slopes", "settings", "note", "remark", "name", "contender"),
)


def read_rows(path: Path, needed: str = "") -> pd.DataFrame | None:
    """A table with empty texts instead of missing ones; None, with a warning where there is a file
    that cannot be read.

    Parameters
    ----------
    needed
        a column without which it counts as unreadable
    """
    if not path.is_file():
        return None
    try:
        table = read_csv(path, dtype=dict.fromkeys(TEXTS, str))
        if needed and needed not in table:
            raise ValueError(f"it has no column {needed!r}")
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        print(f"{path} is left out, since it cannot be read: {why}.", file=sys.stderr)
        return None
    texts = table.select_dtypes(exclude=["number", "bool"])
    return table.assign(**texts.astype(object).where(texts.notna(), ""))


def marked(table: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """The table with a column for each of MARKS appended; existing columns are unchanged."""
    marks = {name: origin.get(name, "") for name in MARKS if name not in table}
    return table.assign(**marks)


def read_marked(path: Path, needed: str, origin: Mapping[str, str]) -> pd.DataFrame | None:
    """As `read_rows`; rows without marks get those of `origin`, which is that of the file."""
    table = read_rows(path, needed)
    return None if table is None else marked(table, origin)


def merged(
    before: pd.DataFrame | None,
    now: pd.DataFrame,
    key: str,
    checked: Collection[str],
    all_ids: Collection[str],
) -> pd.DataFrame:
    """The new rows, and the old rows of claims that were not checked, in the order of `all_ids`.

    Rows of claims that no longer exist are dropped.
    """
    if before is None:
        return now
    stays = before[before[key].isin(set(all_ids) - set(checked))]
    if stays.empty:
        return now
    both = pd.concat([now, stays.reindex(columns=now.columns)] if len(now) else [stays])
    order = {name: position for position, name in enumerate(all_ids)}
    return both.sort_values(key, key=lambda ids: ids.map(order), kind="stable", ignore_index=True)
