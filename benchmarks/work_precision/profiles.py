"""All problems together: performance profiles and data profiles, with bands.

A performance profile (Dolan and More, Math. Program. 91 (2002) 201) is the share of problems on
which a code takes at most so many times as long as the fastest; a data profile (More and Wild, SIAM
J. Optim. 20 (2009) 172) that which it solves within a budget, here of time. Codes take part on
different problems, and a ratio depends on who else does (Gould and Scott, ACM TOMS 43 (2016) 15):
shares are of the problems of each code; two codes are compared on those of both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import binom

from benchmarks.statistics.paired import COVERAGE, FASTER, SLOWER
from benchmarks.work_precision.asked import code_of, errors_of
from benchmarks.work_precision.fronts import OURS

FAILED_COST = math.inf  # of a problem that a code does not solve
# columns that a run fills; all are empty where the engine is missing
RUN_COLUMNS = ("error", "seconds", "steps", "evaluations")


class Share(NamedTuple):
    """A share of problems with the ends of its band."""

    low: float
    share: float
    high: float


def share(solved: int, problems: int) -> Share:
    """The share of solved problems with a bootstrap band of probability COVERAGE.

    The share in problems that are sampled from these with replacement is binomial, so that its
    quantiles need no samples. Where it is 0 or 1 all samples are equal, and the band ends where
    such a result still has the probability (1 - COVERAGE) / 2. NaN without problems.
    """
    if not problems:
        return Share(math.nan, math.nan, math.nan)
    tail, fraction = 0.5 * (1.0 - COVERAGE), solved / problems
    low, high = (
        float(binom.ppf(quantile, problems, fraction)) / problems for quantile in (tail, 1.0 - tail)
    )
    end = tail ** (1.0 / problems)
    return Share(end if solved == problems else low, fraction, 1.0 - end if solved == 0 else high)


def costs(runs: pd.DataFrame, cells: pd.DataFrame, error: float) -> pd.DataFrame:
    """A row for each code and problem on which it was run and whose truth resolves this error.

    The columns are problem, code, cost, ratio and outcome.

    cost     seconds of its fastest run that reaches the error; FAILED_COST where none does
    ratio    to the least cost of the problem; FAILED_COST where that is
    outcome  FASTER where galvi is, with the interval of `fronts.ratios` where there is one, SLOWER,
             TIE, or '' for galvi itself and where neither solves it

    runs   of `benchmarks.work_precision.run`, errors `dependable`
    cells  of `fronts.ratios`
    """
    with_error = [
        name for name, rows in runs.groupby("problem", sort=False) if error in errors_of(rows)
    ]
    run_columns = [name for name in RUN_COLUMNS if name in runs]
    measured = runs[runs["problem"].isin(with_error) & runs[run_columns].notna().any(axis=1)]
    table = measured[["problem"]].assign(code=measured["contender"].map(code_of)).drop_duplicates()
    at_error = cells[(cells["error"] == error) & (cells["contender"] != OURS)]
    at_error = at_error.assign(code=at_error["contender"].map(code_of)).dropna(subset="seconds")
    best = at_error.loc[at_error.groupby(["problem", "code"])["seconds"].idxmin()]
    table = table.merge(best[["problem", "code", "seconds", "outcome"]], how="left")
    table["cost"] = table.pop("seconds").fillna(FAILED_COST)
    least_cost = table.groupby("problem")["cost"].transform("min")
    table["ratio"] = table["cost"] / least_cost.where(np.isfinite(least_cost), 1.0)
    galvi_costs = table[table["code"] == "galvi"].set_index("problem")["cost"]
    table["outcome"] = [
        _outcome(row.code, row.cost, galvi_costs.get(row.problem), row.outcome)
        for row in table.itertuples()
    ]
    return table


def _outcome(code: str, code_cost: float, galvi_cost: float | None, by_intervals: object) -> str:
    if code == "galvi" or galvi_cost is None or code_cost == galvi_cost:
        return ""
    if isinstance(by_intervals, str) and by_intervals:
        return by_intervals
    return FASTER if galvi_cost < code_cost else SLOWER


def profile(values: pd.Series, bounds: Sequence[float]) -> list[Share]:
    """The share of the problems whose value is at most each bound; FAILED_COST is above all."""
    return [share(int((values <= bound).sum()), len(values)) for bound in bounds]
