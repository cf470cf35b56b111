"""Energy beside position: what else is wrong with a run that reaches an error of position."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.asked import errors_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import NOT_REACHED, OURS, fastest
from reports.tables.comparison_tables import heading, is_ours
from reports.tables.number_format import known, readable


def energies(runs: pd.DataFrame) -> pd.DataFrame:
    """As text, from one problem's rows of `benchmarks.work_precision.run`: for each contender, of
    galvi's methods the fastest, a column for each error of position, with the relative error of the
    energy at the end of the run that is the fastest to reach it. Empty where none was measured."""
    if "energy" not in runs or not runs["energy"].notna().any():
        return pd.DataFrame()
    counted = dependable(runs)
    names = counted["contender"].map(lambda name: OURS if is_ours(name) else name)
    lines = []
    for name, rows in counted.groupby(names, sort=False):
        best = {error: fastest(rows, error) for error in errors_of(counted)}
        if any(row is not None for row in best.values()):
            cells = {heading(error): _cell(row) for error, row in best.items()}
            lines.append({"contender": str(name), **cells})
    return pd.DataFrame(lines)


def _cell(row: pd.Series | None) -> str:
    if row is None:
        return NOT_REACHED
    return readable(float(row["energy"]), 2) if known(float(row["energy"])) else ""
