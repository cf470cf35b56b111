"""Tables as CSV whose texts are not executed by a spreadsheet, see `foreign_texts`."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.foreign_texts import guarded, unguarded


def as_csv(table: pd.DataFrame) -> str:
    """The table as CSV with guarded texts, and numbers in full precision."""
    return _with_texts(table, guarded).to_csv(index=False, lineterminator="\n")


def read_csv(source: Path | io.StringIO, **options: Any) -> pd.DataFrame:
    """The table that `as_csv` wrote; options of pandas.read_csv."""
    return _with_texts(pd.read_csv(source, **options), unguarded)


def _with_texts(table: pd.DataFrame, change: Callable[[str], str]) -> pd.DataFrame:
    """A copy of the table with its texts changed; the table itself where no text changes."""
    changed_table = table
    for k, kind in enumerate(table.dtypes):
        if pd.api.types.is_numeric_dtype(kind):
            continue
        cells = list(table.iloc[:, k])
        new = {text: change(text) for text in {cell for cell in cells if isinstance(cell, str)}}
        if any(before != after for before, after in new.items()):
            changed = [new[cell] if isinstance(cell, str) else cell for cell in cells]
            changed_table = table.copy() if changed_table is table else changed_table
            changed_table.isetitem(k, pd.Series(changed, table.index, dtype=kind))
    return changed_table
