"""Read tables that earlier commands wrote, mark their rows with the origin, and merge them."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path

import pandas as pd

from benchmarks.store.cells import read_csv

ORIGIN_COLUMNS = (
    "date",
    "commit",
    "setting",
)  # columns of a row's origin; the setting: quick or default
TEXT_COLUMNS = (  # columns that are read as texts, even if all cells are empty
    *ORIGIN_COLUMNS,
    *("study", "quantity", "label", "status", "absent"),  # of studies
    *("source", "setup", "claimed", "bound", "expected", "reference", "verdict", "reason"),
    *("slopes", "settings", "note", "remark", "name", "contender"),
)


def read_rows(path: Path, required_column: str = "") -> pd.DataFrame | None:
    """Read a table, with "" for missing texts.

    Returns None if there is no file, and, with a warning on stderr, if it cannot be read.

    Parameters
    ----------
    needed
        a column without which the file counts as unreadable
    """
    if not path.is_file():
        return None
    try:
        table = read_csv(path, dtype=dict.fromkeys(TEXT_COLUMNS, str))
        if required_column and required_column not in table:
            raise ValueError(f"it has no column {required_column!r}")
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        print(f"{path} is left out, since it cannot be read: {why}.", file=sys.stderr)
        return None
    texts = table.select_dtypes(exclude=["number", "bool"])
    return table.assign(**texts.astype(object).where(texts.notna(), ""))


def with_origin(table: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """The table with those columns of ORIGIN_COLUMNS that it lacks, filled from `origin`."""
    marks = {name: origin.get(name, "") for name in ORIGIN_COLUMNS if name not in table}
    return table.assign(**marks)


def read_with_origin(
    path: Path, required_column: str, origin: Mapping[str, str]
) -> pd.DataFrame | None:
    """As `read_rows`; columns of ORIGIN_COLUMNS that the file lacks are filled from its
    `origin`."""
    table = read_rows(path, required_column)
    return None if table is None else with_origin(table, origin)


def merge_rows(
    old_rows: pd.DataFrame | None,
    new_rows: pd.DataFrame,
    key: str,
    checked_ids: Collection[str],
    all_ids: Collection[str],
) -> pd.DataFrame:
    """The new rows, and the old rows of claims that were not checked, in the order of `all_ids`.

    Rows of claims that no longer exist are dropped.
    """
    if old_rows is None:
        return new_rows
    kept_rows = old_rows[old_rows[key].isin(set(all_ids) - set(checked_ids))]
    if kept_rows.empty:
        return new_rows
    all_rows = pd.concat(
        [new_rows, kept_rows.reindex(columns=new_rows.columns)] if len(new_rows) else [kept_rows]
    )
    order = {name: position for position, name in enumerate(all_ids)}
    return all_rows.sort_values(
        key, key=lambda ids: ids.map(order), kind="stable", ignore_index=True
    )
