"""Errors to rely on: not one lucky end, and not below what the truth can tell."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.work_precision.fronts import BOUND

FINENESS = r"\b(?:step|epsilon|tolerance)=([\d.e+-]+)"  # the first of a setting


def dependable(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of `benchmarks.work_precision.run` with another `error`; `measured` has their own.

    An error at one time may be small by chance. It counts as the larger of its own and that of the
    next finer setting, which differs by a smaller step (or tolerance) alone; round-off that grows
    from there on is not held against it. A run marked BOUND counts as `resolution`.
    """
    table = table.assign(measured=table["error"])
    if "settings" not in table:
        return table
    settings = table["settings"].fillna("").astype(str)
    rows = table.assign(
        fineness=pd.to_numeric(settings.str.extract(FINENESS)[0], errors="coerce"),
        others=settings.str.replace(FINENESS, "", n=1, regex=True),
    )
    rows = rows[rows["error"].notna() & rows["fineness"].notna()].sort_values("fineness")
    finer = rows.groupby(["problem", "contender", "others"], sort=False)["error"].shift(1)
    counted = np.fmax(table["error"], finer.reindex(table.index))
    least = table["problem"].map({
        name: resolution(runs) for name, runs in table.groupby("problem", sort=False)
    })  # fmt: skip
    bound = table["status"].str.startswith(BOUND, na=False)
    return table.assign(error=counted.mask(bound, np.fmax(counted, least)))


def resolution(runs: pd.DataFrame) -> float:
    """The error below which one problem's truth cannot tell them apart: ten times its own.

    Rows without `truth_error` have the largest one marked BOUND, which is no more than that; 0
    where none is.
    """
    if "truth_error" in runs and runs["truth_error"].notna().any():
        return 10.0 * float(runs["truth_error"].max())
    own = runs["measured"] if "measured" in runs else runs["error"]
    marked = own[runs["status"].str.startswith(BOUND, na=False)]
    return float(marked.max()) if len(marked) else 0.0


def bounds(table: pd.DataFrame, runs: pd.DataFrame) -> pd.Series:
    """Whether each `error` of a table is a bound alone: no larger than its problem's `resolution`
    in these runs."""
    least = {name: resolution(own) for name, own in runs.groupby("problem", sort=False)}
    return table["error"] <= table["problem"].map(least)
