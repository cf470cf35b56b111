"""The tables of studies and of the cost of a step as text: selected columns with headings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from numbers import Real
from types import MappingProxyType

import pandas as pd

from benchmarks.work_precision.cost import COLUMNS
from benchmarks.work_precision.labels import label_of
from reports.tables.number_format import in_full, seconds


def readable_table(
    table: pd.DataFrame,
    headings: Mapping[str, str],
    formats: Mapping[str, Callable[[float], str]] = MappingProxyType({}),
) -> tuple[pd.DataFrame, dict[str, str]]:
    """The columns that have a heading, as text, and heading -> CSS class of those with numbers.

    Empty columns are omitted.

    Parameters
    ----------
    headings
        column -> heading
    formats
        column -> function that formats its numbers, by default `in_full`; texts are unchanged
    """
    shown = table[[name for name in headings if name in table]].astype(object)
    text = shown.apply(lambda column: column.map(partial(_cell, formats.get(column.name, in_full))))
    text = text.loc[:, (text != "").any()]
    numbers = [*table.select_dtypes("number"), *formats]
    return text.rename(columns=dict(headings)), {
        headings[name]: "number" for name in numbers if name in text
    }


def _cell(write_number: Callable[[float], str], value: object) -> object:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return write_number(float(value)) if isinstance(value, Real) else value


def without_common(table: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """The table without those of the columns "date" and "commit" that have a single value, and a
    sentence with these values, or ""."""
    common = {
        name: table[name].iloc[0]
        for name in ("date", "commit")
        if name in table and len(table) and table[name].nunique(dropna=False) == 1
    }
    parts = [f"{'at commit ' * (name == 'commit')}{text}" for name, text in common.items() if text]
    return table.drop(columns=list(common)), f"Measured {', '.join(parts)}." if parts else ""


def readable_cost(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """As `readable_table`, for the table of `benchmarks.work_precision.cost`, whose times have
    units."""
    titles = [label_of(name).title for name in table["problem"]]
    times = {
        column.name: table[column.name].map(seconds)
        for column in COLUMNS
        if column.kind == "seconds"
    }
    headings = {column.name: column.heading for column in COLUMNS if column.heading}
    text, numbers = readable_table(table.assign(problem=titles, **times), headings)
    return text, numbers | dict.fromkeys([headings[name] for name in times], "number")
