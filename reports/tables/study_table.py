"""The table of a study on the page: selected columns with headings."""

from __future__ import annotations

import re
from collections.abc import Mapping

import pandas as pd
from pandas.api.types import is_bool_dtype, is_numeric_dtype

from reports.tables.number_format import readable

NINES = re.compile(r"(0\.9+)0*")


def readable_table(
    frame: pd.DataFrame, headings: Mapping[str, str]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """The columns with a heading, as text, and their CSS classes; empty columns are omitted."""
    shown = frame.reindex(columns=[name for name in headings if name in frame])
    truths = [name for name in shown if is_bool_dtype(shown[name])]
    numbers = [name for name in shown if is_numeric_dtype(shown[name]) and name not in truths]
    text = shown.astype(object)
    for name in truths:
        text[name] = ["yes" if value else "no" for value in shown[name]]
    for name in numbers:
        text[name] = [_number(float(value)) for value in shown[name]]
    text = text.loc[:, [bool((text[name] != "").any()) for name in text]]
    return text.rename(columns=dict(headings)), {headings[name]: "number" for name in numbers}


def without_empty_status(table: pd.DataFrame) -> pd.DataFrame:
    """The table without its column `status` where that says nothing."""
    said = "status" in table and (table["status"] != "").any()
    return table if said else table.drop(columns="status", errors="ignore")


def without_common(table: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """The table without the columns of commit and date that have one value, and a sentence with
    these values."""
    common = {
        name: table[name].iloc[0] for name in ("date", "commit")
        if name in table and len(table) and table[name].nunique(dropna=False) == 1
    }  # fmt: skip
    words = [f"{'at commit ' * (name == 'commit')}{text}" for name, text in common.items() if text]
    return table.drop(columns=list(common)), f"Measured {', '.join(words)}." if words else ""


def _number(value: float) -> str:
    """Counts in full, eccentricities with all their nines, numbers of one digit with no more of
    them, errors with three."""
    if float(value).is_integer() and abs(value) < 1e15:
        return f"{value:.0f}"
    if nines := NINES.fullmatch(f"{value:.6f}"):
        return nines[1]
    return readable(value, 1 if float(f"{value:.0e}") == value else 3)
