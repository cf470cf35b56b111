"""The tidy table that studies return and that claims, tables and figures read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

from galvi.arrays import Array

# column: (description, dtype)
COLUMNS: Mapping[str, tuple[str, str]] = {
    "study": ("name of a group of series, e.g. 'n-refinement'", "object"),
    "quantity": ("what `value` is, e.g. 'one-step error'", "object"),
    "n": ("number of basis functions, degree + 1; or the seed of a sampling", "float64"),
    "step": ("step size, in the problem's unit of time", "float64"),
    "steps": ("number of steps", "float64"),
    "t": ("time, for histories and orbits", "float64"),
    "label": ("body, or whose motion it is", "object"),
    "x": ("place of a body, in the problem's unit of length", "float64"),
    "y": ("likewise", "float64"),
    "z": ("likewise", "float64"),
    "value": ("the number; NaN for a place, or when the run failed", "float64"),
    "status": ("empty when the run succeeded, else why it ended", "object"),
    "absent": ("the package for want of which it was not measured, or empty", "object"),
    "force_evaluations": ("of the run, one for each stage and pass", "float64"),
}
BLANK_ROW = {name: float("nan") if kind == "float64" else "" for name, (_, kind) in COLUMNS.items()}


def row(**values: Any) -> dict[str, Any]:
    """One observation; omitted columns are NaN, or "" for text. KeyError for an unknown column."""
    unknown = values.keys() - COLUMNS.keys()
    if unknown:
        raise KeyError(f"a tidy row has the columns {', '.join(COLUMNS)}; received {unknown}.")
    return {**BLANK_ROW, **values}


def rows(values: Mapping[str, float], **where: Any) -> list[dict[str, Any]]:
    """One observation for each (quantity, value)."""
    return [row(quantity=quantity, value=value, **where) for quantity, value in values.items()]


def history(quantity: str, t: Array, values: Array, **where: Any) -> list[dict[str, Any]]:
    """One observation for each time; values (k,), or positions (k, 3)."""
    if np.ndim(values) == 1:
        pairs = zip(t, values, strict=True)
        return [row(quantity=quantity, t=s, value=value, **where) for s, value in pairs]
    positions = zip(t, values, strict=True)
    return [row(quantity=quantity, t=s, x=x, y=y, z=z, **where) for s, (x, y, z) in positions]


def failure(run: Any) -> str:
    """The status of a failed run, for the column `status`; "" where it succeeded."""
    return "" if run.success else run.status


def table_of(rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """A table of the rows with exactly the COLUMNS, in their order and with their types."""
    table = pd.DataFrame(list(rows), columns=list(COLUMNS))
    return table.astype({name: kind for name, (_, kind) in COLUMNS.items()})


def pick(table: pd.DataFrame, **where: Any) -> pd.DataFrame:
    """The rows whose columns have these values; possibly none."""
    if table.empty:
        return _empty().copy()
    is_chosen = np.full(len(table), True)
    for name, value in where.items():
        is_chosen &= table[name].to_numpy() == value
    return table[is_chosen]


@cache
def _empty() -> pd.DataFrame:
    return table_of([])


def series(table: pd.DataFrame, by: str, **where: Any) -> tuple[Array, Array]:
    """(n increasing or step decreasing, values) of these rows, in the order of refinement."""
    rows = pick(table, **where).sort_values(by, ascending=by == "n")
    return rows[by].to_numpy(np.float64), rows["value"].to_numpy(np.float64)


def number(table: pd.DataFrame, **where: Any) -> float:
    """The value of the one row with these values; NaN without a row, ValueError for several."""
    values = pick(table, **where)["value"]
    if len(values) > 1:
        raise ValueError(f"expected one row with {where}; received {len(values)}.")
    return float(values.iloc[0]) if len(values) else float("nan")
