"""Promises of `galvi.recommend`: kept, and a recommender that makes empty ones is caught."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest

import galvi
from benchmarks.studies import recommendation
from benchmarks.studies.recommendation import (
    BROKEN,
    GAVE_UP,
    KEPT,
    REFUSED,
    promise,
    recommendation_table,
)

ORBIT = galvi.problems.kepler(0.6)


def advised(problem: galvi.Problem, error: float, duration: float, **options: Any) -> Any:
    """By evaluations, so that every machine and run finds the same."""
    return galvi.recommend(problem, error, duration, by="evaluations", degrees=(8, 16), **options)


KNOWN: dict[tuple[object, ...], Any] = {}


def advised_before(problem: galvi.Problem, *asked: float, **options: Any) -> Any:
    """As `advised`, which is asked once."""
    key = (problem.name, *asked, *options.items())
    if key not in KNOWN:
        KNOWN[key] = advised(problem, *asked, **options)
    return KNOWN[key]


def table(recommend: Any = advised) -> pd.DataFrame:
    return recommendation_table(True, recommend=recommend)


@pytest.mark.slow(beside="test_a_recommender_that_refuses_what_can_be_reached_is_caught")
def test_promises_are_kept_for_every_problem_and_error() -> None:
    rows = table(advised_before)
    assert tuple(rows.columns) == recommendation.COLUMNS
    assert not rows.duplicated(["problem", "asked", "measured_over"]).any()
    assert len(rows) == 16 and set(rows["promise"]) == {KEPT}
    assert (rows["predicted"] <= rows["asked"]).all()
    whole = rows[rows["measured_over"] == "all of it"]
    assert (whole["found"] <= 1.1 * whole["predicted"]).all()  # 1.01 when this was written


@pytest.mark.slow(beside="test_a_recommender_that_refuses_what_can_be_reached_is_caught")
def test_a_recommender_that_believes_that_errors_shrink_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(importlib.import_module("galvi.recommend.scan"), "POWERS", (-2.0, -2.0))
    rows = table()
    assert set(rows.loc[rows["measured_over"] == "all of it", "promise"]) == {KEPT}
    assert BROKEN in set(rows.loc[rows["measured_over"] != "all of it", "promise"])


def test_a_recommender_that_refuses_what_can_be_reached_is_caught() -> None:
    rows = table(
        lambda *asked, **options: replace(advised_before(*asked, **options), reached=False)
    )
    assert set(rows["promise"]) == {GAVE_UP}


@pytest.mark.parametrize(
    ("asked", "error", "reached", "found", "verdict"),
    [
        (1e-6, 5e-7, True, 1.05e-6, KEPT),
        (1e-6, 5e-7, True, 1.15e-6, BROKEN),
        (1e-6, 5e-7, True, float("nan"), BROKEN),
        (1e-12, 4e-12, False, 1e-11, REFUSED),
        (1e-12, 4e-12, False, 2e-11, BROKEN),
        (1e-10, 4e-10, False, 4e-10, GAVE_UP),
        (1e-12, float("inf"), False, 1.0, GAVE_UP),
        (1e-12, float("nan"), False, 1.0, BROKEN),
    ],
)
def test_the_verdict_follows_the_rule_from_both_sides(
    asked: float, error: float, reached: bool, found: float, verdict: str
) -> None:
    choice = replace(advised_before(ORBIT, 1e-3, 10.0), asked=asked, error=error, reached=reached)
    assert promise(choice, found, rounding=5e-13) == verdict


@pytest.mark.parametrize(("found", "verdict"), [(2.9e-6, KEPT), (3.1e-6, BROKEN)])
def test_an_extrapolated_error_may_be_off_by_more(found: float, verdict: str) -> None:
    choice = replace(advised_before(ORBIT, 1e-3, 10.0), asked=1e-6, error=5e-7, measured=5.0)
    assert promise(choice, found, rounding=5e-13) == verdict
