"""Profiles count each problem once, failures as never, and their bands cover."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from benchmarks.statistics.paired import FASTER, SLOWER
from benchmarks.work_precision.fronts import ratios
from benchmarks.work_precision.profiles import FAILED, Share, costs, profile, share

ERROR = 1e-6


def runs(*rows: tuple[str, str, float, float], **more: Any) -> pd.DataFrame:
    """Rows (problem, contender, error, seconds)."""
    table = pd.DataFrame(rows, columns=["problem", "contender", "error", "seconds"])
    settings = [f"step={k}" for k in range(len(table))]
    return table.assign(
        settings=settings, is_truth=False, status="", steps=1.0, evaluations=math.nan, **more
    )


def found(table: pd.DataFrame) -> pd.DataFrame:
    return costs(table, ratios(table, [ERROR]), ERROR).set_index(["problem", "code"])


THREE = [
    ("a", "galvi degree 8", 1e-7, 1.0), ("a", "galvi degree 4", 1e-7, 3.0),
    ("a", "peer", 1e-7, 2.0),
    ("b", "galvi degree 8", 1e-7, 4.0), ("b", "peer", 1e-7, 1.0),
    ("c", "galvi degree 8", 1e-7, 1.0), ("c", "peer", 1e-3, 1.0), ("c", "peer", 1e-5, 1.0),
]  # fmt: skip


def test_a_ratio_is_to_the_fastest_code_and_a_failure_counts_once_as_never() -> None:
    table = found(runs(*THREE))
    assert table["ratio"].to_dict() == {
        ("a", "galvi"): 1.0, ("a", "peer"): 2.0, ("b", "galvi"): 4.0, ("b", "peer"): 1.0,
        ("c", "galvi"): 1.0, ("c", "peer"): FAILED,
    }  # fmt: skip
    peer = table.xs("peer", level="code")
    assert [one.share for one in profile(peer["ratio"], [1.0, 2.0, 1e9])] == [1 / 3, 2 / 3, 2 / 3]
    assert list(peer["outcome"]) == [FASTER, SLOWER, FASTER]


def test_a_code_that_fails_everywhere_is_flat_at_zero_and_changes_no_other_ratio() -> None:
    bad = [(problem, "broken", math.nan, math.nan) for problem in "abc" for _ in range(4)]
    table, before = found(runs(*THREE, *bad)), found(runs(*THREE))
    broken = table.xs("broken", level="code")
    assert len(broken) == 3 and (broken["ratio"] == FAILED).all()
    assert all(one.share == one.low == 0.0 for one in profile(broken["ratio"], [1.0, 1e300]))
    kept = table["ratio"].drop("broken", level="code")
    assert kept.to_dict() == before["ratio"].to_dict()


def test_where_nobody_gets_there_nobody_is_the_fastest() -> None:
    table = found(runs(("a", "galvi degree 8", 1e-2, 1.0), ("a", "peer", 1e-3, 1.0)))
    assert (table["ratio"] == FAILED).all() and (table["outcome"] == "").all()


def test_a_winner_that_was_never_run_has_no_place() -> None:
    """An engine that is missing leaves rows with a reason; a row of times without an error, as of a
    setting between two, wins nothing."""
    absent = runs(*THREE, ("a", "heyoka", math.nan, math.nan))
    absent.loc[len(THREE), "steps"] = math.nan
    assert "heyoka" not in found(absent).index.get_level_values("code")
    invented = runs(*THREE, ("a", "peer", math.nan, 1e-9), ("b", "faster", math.nan, 1e-9))
    table = found(invented)
    assert table.loc[("a", "peer"), "cost"] == 2.0 and table.loc[("b", "peer"), "ratio"] == 1.0
    assert table.loc[("b", "faster"), "cost"] == FAILED


def test_a_problem_whose_truth_cannot_tell_the_error_is_not_counted() -> None:
    told = runs(*THREE)
    told["truth_error"] = [1e-6 if problem == "b" else 1e-16 for problem in told["problem"]]
    assert set(found(told).index.get_level_values("problem")) == {"a", "c"}


Band = Callable[[int, int], Share]


def covered(problems: int, true: float, band: Band = share) -> float:
    """How often the band holds the true share, over what so many problems may show."""
    held = 0.0
    for solved in range(problems + 1):
        low, _, high = band(solved, problems)
        held += float(binom.pmf(solved, problems, true)) * (low <= true <= high)
    return held


def too_narrow(solved: int, problems: int) -> Share:
    low, middle, high = share(solved, problems)
    return Share(middle - 0.3 * (middle - low), middle, middle + 0.3 * (high - middle))


def without_ends(solved: int, problems: int) -> Share:
    """The bootstrap alone, whose draws are all equal where no problem, or each, is solved."""
    found = share(solved, problems)
    return Share(*[found.share] * 3) if solved in (0, problems) else found


@pytest.mark.slow_cases("28")
@pytest.mark.parametrize("problems", [5, 12, 28])
def test_bands_cover_and_ones_that_are_too_small_are_seen(problems: int) -> None:
    trues = [0.02 * k for k in range(1, 50)]

    def cover(band: Band) -> list[float]:
        return [covered(problems, true, band) for true in trues]

    assert np.mean(cover(share)) > 0.93 and min(cover(share)) > 0.8
    assert np.mean(cover(too_narrow)) < 0.6
    assert min(cover(without_ends)) < 0.5


def test_no_problems_have_no_share() -> None:
    assert math.isnan(share(0, 0).share)
