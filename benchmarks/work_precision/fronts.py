"""Work-precision fronts of contenders, and times of settings that reach an error.

A setting counts where it was run: nothing is interpolated between two of them. All settings of a
problem were timed in the same rounds, so that their `seconds` compare.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.statistics.paired import UNKNOWN, Interval, outcome, ratio, read

NOT_REACHED = "not reached"
OURS = "galvi, best"
COLUMNS = (
    *("problem", "contender", "error", "settings", "seconds", "ratio", "low", "high"),
    *("noise_low", "noise_high", "outcome", "closer"),
)
CLOSER_FACTOR = 10.0  # runs that are this many times as accurate as requested are marked


def front(table: pd.DataFrame) -> pd.DataFrame:
    """The Pareto-optimal rows in error and time of each problem and contender.

    Ordered by decreasing error, hence increasing time. Rows without error or time are omitted.
    """
    usable = table[(table["error"] > 0.0) & (table["seconds"] > 0.0)]
    groups = usable.groupby(["problem", "contender"], sort=False)
    on_front = [index for _, rows in groups for index in front_indices(rows)]
    return usable.loc[on_front].reset_index(drop=True)


def front_indices(rows: pd.DataFrame) -> list[Any]:
    """Indices, by increasing time, of the rows with error and time that no other row beats in
    both."""
    usable = rows[(rows["error"] > 0.0) & (rows["seconds"] > 0.0)]
    ordered = usable.sort_values(["seconds", "error"])["error"]
    return list(ordered.index[ordered < ordered.cummin().shift(fill_value=math.inf)])


def fastest(rows: pd.DataFrame, target: float) -> pd.Series | None:
    """The row of least `seconds` among those that reach the error.

    Where none does, the row of the run that is the truth; None without such a row.
    """
    seconds, error = rows["seconds"].to_numpy(float), rows["error"].to_numpy(float)
    eligible = (seconds > 0.0) & (error > 0.0) & (error <= target)
    if not eligible.any():
        eligible = (seconds > 0.0) & rows["is_truth"].to_numpy(bool)
    return (
        rows.iloc[int(np.argmin(np.where(eligible, seconds, np.inf)))] if eligible.any() else None
    )


def seconds_at(errors: Sequence[float], seconds: Sequence[float], target: float) -> float:
    """The least time of the runs that reach an error; NaN where none does."""
    return min((s for e, s in zip(errors, seconds, strict=True) if e <= target), default=math.nan)


def ratios(table: pd.DataFrame, errors: Sequence[float]) -> pd.DataFrame:
    """Times at equal error: one row of COLUMNS for each problem, contender and error.

    settings   settings of the contender's fastest run that reaches the error
    seconds    time of this run
    ratio      this time over that of galvi's fastest (above 1: galvi is faster), the median over
               the rounds that both took part in, for galvi's own the ratio of the medians, by
               which the fastest is chosen; 'not reached' where no run of the contender
               reaches the error, 'galvi: not reached' where only none of galvi's does
    low, high  the ratio's interval; NaN where the two shared too few rounds
    noise_low, noise_high  that of galvi's run against itself in these rounds
    outcome    of both intervals, see `benchmarks.statistics.paired`
    closer     ratio of the requested error to the largest error of its runs that reach it, where
               that exceeds CLOSER_FACTOR: a looser setting might take less time

    Rows of contender 'galvi, best' hold galvi's time and, as ratio, 1. A contender whose run is the
    truth has that run's time at errors that no other run of it reaches.
    """
    rows = []
    for problem, problem_rows in table.groupby("problem", sort=False):
        contender_rows = {
            str(name): part
            for name, part in problem_rows[problem_rows["seconds"] > 0.0].groupby(
                "contender", sort=False
            )
            if _took_part(part)
        }
        galvi_rows = problem_rows[
            (problem_rows["seconds"] > 0.0) & problem_rows["contender"].str.startswith("galvi")
        ]
        for target in errors if contender_rows else ():
            best = {name: fastest(part, target) for name, part in contender_rows.items()}
            reached = [row for row in best.values() if row is not None]
            by_galvi = [row for row in reached if row["contender"].startswith("galvi")]
            galvi_run = min(by_galvi, key=lambda row: row["seconds"], default=None)
            rows += [
                {
                    "problem": problem,
                    "contender": name,
                    "error": target,
                    **_cell(row, galvi_run),
                    "closer": _closer(contender_rows.get(name, galvi_rows), target),
                }
                for name, row in {OURS: galvi_run, **best}.items()
            ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def at_smallest(table: pd.DataFrame) -> pd.DataFrame:
    """Each contender at the smallest error of its front, round-off if its settings extend that far.

    Columns as of `ratios`; ``error`` differs from row to row, and so does galvi's time.
    """
    tables = []
    for problem in table["problem"].drop_duplicates():
        problem_rows = table[table["problem"] == problem]
        smallest_errors = (
            front(problem_rows).groupby("contender", sort=False)["error"].min().to_dict()
        )
        galvi_errors = [
            error for name, error in smallest_errors.items() if name.startswith("galvi")
        ]
        smallest_errors |= {OURS: min(galvi_errors)} if galvi_errors else {}
        times = ratios(problem_rows, sorted(set(smallest_errors.values())))
        tables.append(times[times["error"] == times["contender"].map(smallest_errors)])
    return pd.concat(tables, ignore_index=True) if tables else ratios(table, ())


def unfounded(cells: pd.DataFrame, table: pd.DataFrame) -> list[str]:
    """A sentence for each cell of `ratios` whose setting was not run, or misses its error."""
    sentences = []
    for cell in cells[cells["seconds"].notna()].to_dict("records"):
        runs = table[
            (table["problem"] == cell["problem"])
            & (table["settings"] == cell["settings"])
            & ((table["contender"] == cell["contender"]) | (cell["contender"] == OURS))
        ]
        if fastest(runs, cell["error"]) is None:
            sentences.append(
                f"{cell['problem']}: {cell['contender']} at {cell['error']:g} names the setting "
                f"{cell['settings'] or 'without a name'}, which no run that reaches it had."
            )
    return sentences


def _took_part(rows: pd.DataFrame) -> bool:
    timed = rows[rows["seconds"] > 0.0]
    return bool(((timed["error"] > 0.0) | timed["is_truth"]).any())


def _cell(row: pd.Series | None, galvi_run: pd.Series | None) -> dict[str, Any]:
    nan = math.nan
    cell: dict[str, Any] = dict.fromkeys(COLUMNS[3:], nan) | {"settings": "", "outcome": ""}
    if row is None:
        return cell | {"ratio": NOT_REACHED}
    cell |= {"settings": row.get("settings", ""), "seconds": float(row["seconds"])}
    if galvi_run is None:
        return cell | {"ratio": f"galvi: {NOT_REACHED}"}
    interval = (
        UNKNOWN if row.name == galvi_run.name else _in_shared_rounds(row, "rounds", galvi_run)
    )
    noise = _in_shared_rounds(galvi_run, "again", galvi_run)
    of_medians = math.isnan(interval.median) or str(row["contender"]).startswith("galvi")
    return cell | {
        "ratio": cell["seconds"] / galvi_run["seconds"] if of_medians else interval.median,
        "low": interval.low,
        "high": interval.high,
        "noise_low": noise.low,
        "noise_high": noise.high,
        "outcome": outcome(interval, noise),
    }


def _in_shared_rounds(row: pd.Series, name: str, galvi_run: pd.Series) -> Interval:
    """The ratio of its times, in the column of this name, to galvi's in the rounds of both."""
    pairs = list(zip(read(row.get(name)), read(galvi_run.get("rounds")), strict=False))
    return ratio(*zip(*pairs, strict=True)) if pairs else UNKNOWN


def _closer(runs: pd.DataFrame, error: float) -> float:
    loosest = runs["error"][(runs["error"] > 0.0) & (runs["error"] <= error)].max()
    return error / loosest if error / loosest > CLOSER_FACTOR else math.nan
