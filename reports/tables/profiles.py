"""All problems together: what share of its problems a code solves, and beside galvi."""

from __future__ import annotations

import pandas as pd

from benchmarks.statistics.paired import FASTER, SLOWER, TIE
from benchmarks.work_precision.fronts import ratios
from benchmarks.work_precision.profiles import Share, costs, profile, share
from reports.tables.comparison_tables import heading

SHOWN = (1e-4, 1e-8)  # errors
MIN_PROBLEMS = 5  # problems, of which a share is said
FACTORS = (1.0, 10.0)  # of the fastest


def costs_at(runs: pd.DataFrame) -> dict[float, pd.DataFrame]:
    """Error -> `benchmarks.work_precision.profiles.costs` of the rows of a comparison."""
    cells = ratios(runs, SHOWN)
    return {error: costs(runs, cells, error) for error in SHOWN}


def profile_table(runs: pd.DataFrame) -> pd.DataFrame:
    """As text, a line for each code and error: problems, shares with their bands, and on how many
    of them galvi is faster, ties, is slower."""
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
    """E.g. 80 % (60 to 100)."""
    low, middle, high = (round(100.0 * number) for number in band)
    return f"{middle} % ({low} to {high})"
