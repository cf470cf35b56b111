"""All problems together: the fraction of problems that a code solves, and how galvi compares."""

from __future__ import annotations

import pandas as pd

from benchmarks.statistics.paired import FASTER, SLOWER, TIE
from benchmarks.work_precision.fronts import ratios
from benchmarks.work_precision.profiles import Share, costs, profile, share
from reports.tables.comparison_tables import heading

TABLE_ERRORS = (1e-4, 1e-8)  # errors of the table
MIN_PROBLEMS = 5  # smallest number of problems of a code in the table
FACTORS = (1.0, 10.0)  # multiples of the fastest code's time


def costs_at(runs: pd.DataFrame) -> dict[float, pd.DataFrame]:
    """Error -> `benchmarks.work_precision.profiles.costs` of the rows of a comparison."""
    cells = ratios(runs, TABLE_ERRORS)
    return {error: costs(runs, cells, error) for error in TABLE_ERRORS}


def profile_table(runs: pd.DataFrame) -> pd.DataFrame:
    """A line of texts for each error and code: its number of problems, fractions of them with
    their bands, and on how many galvi is faster, ties, or is slower."""
    lines = []
    for error, table in costs_at(runs).items():
        for code, rows in table.groupby("code", sort=False):
            if len(rows) < MIN_PROBLEMS:
                continue
            fastest, within_ten = profile(rows["ratio"], FACTORS)
            solved = int((rows["cost"] < float("inf")).sum())
            outcomes = [str((rows["outcome"] == name).sum()) for name in (FASTER, TIE, SLOWER)]
            lines.append(
                {
                    "error": heading(error),
                    "code": str(code),
                    "problems": str(len(rows)),
                    "solved": _percent(share(solved, len(rows))),
                    "within 10 times the fastest": _percent(within_ten),
                    "fastest": _percent(fastest),
                    "galvi faster, tie, slower": ", ".join(outcomes) * (code != "galvi"),
                }
            )
    return pd.DataFrame(lines)


def _percent(band: Share) -> str:
    """A fraction with its band in percent, e.g. 80 % (60 to 100)."""
    low, middle, high = (round(100.0 * number) for number in band)
    return f"{middle} % ({low} to {high})"
