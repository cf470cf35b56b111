"""Keep the rows of claims that were not checked this time, with their dates."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path

import pandas as pd

MARKS = ("date", "commit", "setting")  # origin of a row; setting: quick or default


def marked(table: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """The table with a column for each of MARKS appended; existing columns are unchanged."""
    marks = {name: origin.get(name, "") for name in MARKS if name not in table}
    return table.assign(**marks)


def written(path: Path, key: str, origin: Mapping[str, str]) -> pd.DataFrame | None:
    """The rows of the file, marked; None when it is missing or (with a warning) unreadable.

    key     required column with the ids of the claims
    origin  marks for rows without their own
    """
    if not path.is_file():
        return None
    try:
        table = pd.read_csv(path)
        if key not in table:
            raise ValueError(f"it has no column {key!r}")
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        print(f"The rows of {path} are not kept, since it cannot be read: {why}.", file=sys.stderr)
        return None
    text = [name for name in table if table[name].dtype.kind not in "fiu"]
    return marked(table, origin).fillna(dict.fromkeys((*text, *MARKS), ""))


def merged(
    before: pd.DataFrame | None, now: pd.DataFrame, key: str, checked: Collection[str],
    known: Collection[str],
) -> pd.DataFrame:  # fmt: skip
    """The new rows, and the old rows of claims that were not checked, in the order of `known`.

    Rows of claims that no longer exist are dropped.
    """
    if before is None:
        return now
    stays = before[before[key].isin(set(known) - set(checked))]
    if stays.empty:
        return now
    both = pd.concat([now, stays.reindex(columns=now.columns)] if len(now) else [stays])
    places = {name: place for place, name in enumerate(known)}
    return both.sort_values(key, key=lambda ids: ids.map(places), kind="stable", ignore_index=True)
