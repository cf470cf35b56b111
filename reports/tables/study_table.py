"""The table of a study on the page: selected columns with headings."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from pandas.api.types import is_numeric_dtype

from reports.tables.number_format import readable


def readable_table(
    frame: pd.DataFrame, headings: Mapping[str, str]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """The columns with a heading, as text, and their CSS classes; empty columns are omitted."""
    shown = frame.reindex(columns=[name for name in headings if name in frame])
    numbers = [name for name in shown if is_numeric_dtype(shown[name])]
    text = shown.astype(object)
    for name in numbers:
        text[name] = [_number(float(value)) for value in shown[name]]
    text = text.loc[:, [bool((text[name] != "").any()) for name in text]]
    return text.rename(columns=dict(headings)), {headings[name]: "number" for name in numbers}


def _number(value: float) -> str:
    """Counts in full, eccentricities with all their nines, errors with three digits."""
    if value.is_integer() and abs(value) < 1e15:
        return f"{value:.0f}"
    return f"{value:.6f}".rstrip("0") if 0.9 <= value < 1.0 else readable(value)
