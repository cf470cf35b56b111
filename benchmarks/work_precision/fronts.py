"""Work-precision fronts of contenders, and times at matched error."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

NOT_REACHED = "not reached"
OURS = "galvi, best"
TRUTH = "truth"  # status of the row that the others are compared with


def front(table: pd.DataFrame) -> pd.DataFrame:
    """The Pareto-optimal rows in error and time of each problem and contender.

    Ordered by decreasing error, hence increasing time. Rows without error or time are omitted.
    """
    usable = table[(table["error"] > 0.0) & (table["seconds"] > 0.0)]
    kept = []
    for _, rows in usable.groupby(["problem", "contender"], sort=False):
        best = math.inf
        for index, seen in rows.sort_values(["seconds", "error"])["error"].items():
            if seen < best:
                best = seen
                kept.append(index)
    return usable.loc[kept].reset_index(drop=True)


def seconds_at(errors: Sequence[float], seconds: Sequence[float], target: float) -> float:
    """Time at an error, by interpolation of logarithms along a front (falling error, rising time).

    The fastest point's time when its error is below the target; NaN when the front ends above it.
    """
    e, s = np.asarray(errors, dtype=np.float64), np.asarray(seconds, dtype=np.float64)
    if e.size == 0 or e.min() > target:
        return math.nan
    return float(np.exp(np.interp(-math.log(target), -np.log(e), np.log(s))))


def ratios(table: pd.DataFrame, errors: Sequence[float]) -> pd.DataFrame:
    """Times at matched errors: one row for each problem, contender and error.

    Columns problem, contender, error, seconds, ratio. ``ratio`` is the contender's time over that
    of the fastest galvi method at the same error (above 1: galvi is faster); 'not reached' where
    the contender's front ends above the error, 'galvi: not reached' where only galvi's does. Rows
    of contender 'galvi, best' hold galvi's time. A contender whose run is the truth has that run's
    time at errors that no other run of it reaches.
    """
    fronts = front(table)
    rows = []
    for problem in fronts["problem"].drop_duplicates():
        here = fronts[fronts["problem"] == problem]
        contenders = {
            name: part.sort_values("error", ascending=False)
            for name, part in here.groupby("contender", sort=False)
        }
        for target in errors:
            times = {
                name: seconds_at(part["error"], part["seconds"], target)
                for name, part in contenders.items()
            }
            ours = [t for name, t in times.items() if name.startswith("galvi") and t == t]
            truths = {
                name: seconds
                for name, seconds in _truths(table, problem).items()
                if math.isnan(times.get(name, math.nan))
            }
            times = {OURS: min(ours) if ours else math.nan, **times, **truths}
            for name, seconds in times.items():
                rows.append(
                    {
                        "problem": problem,
                        "contender": name,
                        "error": target,
                        "seconds": seconds,
                        "ratio": _ratio(seconds, times[OURS]),
                    }
                )
    return pd.DataFrame(rows, columns=["problem", "contender", "error", "seconds", "ratio"])


def at_smallest(table: pd.DataFrame) -> pd.DataFrame:
    """Each contender at the smallest error of its front, round-off if its settings extend that far.

    Columns as of `ratios`; ``error`` differs from row to row, and so does galvi's time.
    """
    found = []
    for problem in table["problem"].drop_duplicates():
        here = table[table["problem"] == problem]
        ends = front(here).groupby("contender", sort=False)["error"].min().to_dict()
        ours = [error for name, error in ends.items() if name.startswith("galvi")]
        ends |= {OURS: min(ours)} if ours else {}
        times = ratios(here, sorted(set(ends.values())))
        found.append(times[times["error"] == times["contender"].map(ends)])
    return pd.concat(found, ignore_index=True) if found else ratios(table, ())


def _truths(table: pd.DataFrame, problem: str) -> dict[str, float]:
    """The fastest time of each contender that is the truth here."""
    rows = table[(table["problem"] == problem) & (table["status"] == TRUTH)]
    return rows.groupby("contender")["seconds"].min().to_dict()


def _ratio(seconds: float, ours: float) -> float | str:
    if math.isnan(seconds):
        return NOT_REACHED
    return f"galvi: {NOT_REACHED}" if math.isnan(ours) else seconds / ours
