"""Tables as CSV whose texts run nothing where they are opened: see `foreign_texts`."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.foreign_texts import guarded, unguarded


def as_csv(frame: pd.DataFrame) -> str:
    """CSV text with harmless texts, and numbers in full precision: they are read back unchanged."""
    return _with_texts(frame, guarded).to_csv(index=False, lineterminator="\n")


def read_csv(source: Path | io.StringIO, **options: Any) -> pd.DataFrame:
    """What `as_csv` wrote, by pandas with these options."""
    return _with_texts(pd.read_csv(source, **options), unguarded)


def _with_texts(frame: pd.DataFrame, change: Callable[[str], str]) -> pd.DataFrame:
    """The frame with its texts changed; itself where none is."""
    result = frame
    for k, kind in enumerate(frame.dtypes):
        if pd.api.types.is_numeric_dtype(kind):
            continue
        cells = list(frame.iloc[:, k])
        new = {text: change(text) for text in {one for one in cells if isinstance(one, str)}}
        if any(before != after for before, after in new.items()):
            changed = [new[one] if isinstance(one, str) else one for one in cells]
            result = frame.copy() if result is frame else result
            result.isetitem(k, pd.Series(changed, frame.index, dtype=kind))
    return result
