"""Errors that are neither small by chance at one end nor below the resolution of the truth."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

FINENESS_PATTERN = r"\b(?:step|epsilon|tolerance)=([\d.e+-]+)"  # the first match in a setting


def dependable(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of a comparison with the `error` that counts; unchanged if they have `own_error`.

    An error at one time may be small by chance. The larger of `own_error`, that of the run, and of
    the error of the next finer setting counts, which differs by a smaller step (or tolerance)
    alone; errors of still finer settings do not count. `error` is at least the `resolution`, and
    `error_is_bound` tells where it is that.
    """
    if "own_error" in table:
        return table
    settings = table["settings"].fillna("").astype(str)
    rows = table.assign(
        fineness=pd.to_numeric(settings.str.extract(FINENESS_PATTERN)[0], errors="coerce"),
        others=settings.str.replace(FINENESS_PATTERN, "", n=1, regex=True),
    )
    rows = rows[rows["error"].notna() & rows["fineness"].notna()].sort_values("fineness")
    finer_error = rows.groupby(["problem", "contender", "others"], sort=False)["error"].shift(1)
    counted = np.fmax(table["error"], finer_error.reindex(table.index))
    counted = table.assign(error=np.maximum(counted, _resolutions(table, table)))
    return counted.assign(error_is_bound=error_is_bound(counted, table), own_error=table["error"])


def resolution(runs: pd.DataFrame) -> float:
    """The least error that a problem's truth resolves, ten times its own error; 0 where that is
    unknown."""
    truth_error = float(runs["truth_error"].max()) if "truth_error" in runs else math.nan
    return 0.0 if math.isnan(truth_error) else 10.0 * truth_error


def error_is_bound(table: pd.DataFrame, runs: pd.DataFrame) -> pd.Series:
    """Whether each `error` of a table is at most the `resolution` of its problem in these runs, and
    so a bound only."""
    return table["error"] <= _resolutions(table, runs)


def _resolutions(table: pd.DataFrame, runs: pd.DataFrame) -> pd.Series:
    """The `resolution` in these runs, of the problem of each row of a table."""
    by_problem = {
        name: resolution(problem_runs) for name, problem_runs in runs.groupby("problem", sort=False)
    }
    return table["problem"].map(by_problem)
