"""Each rule of the verdicts, from both sides, and with NaN."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.checks import bounds
from benchmarks.checks.bounds import CONTRADICTED, EXCEEDS, HOLDS, NOT_RUN, Drift
from benchmarks.statistics.convergence_fits import Fit

NAN = math.nan


def fit(rate: float, uncertainty: float = 0.001) -> Fit:
    return Fit("geometric", rate, uncertainty, (1.0, 9.0), 9, 1.0)


@pytest.mark.parametrize(
    ("rate", "verdict"),
    [
        (0.5529, EXCEEDS), (0.5531, HOLDS), (0.56, HOLDS), (0.5669, HOLDS), (0.5671, CONTRADICTED),
        (0.99, CONTRADICTED), (NAN, NOT_RUN),
    ],
)  # fmt: skip
def test_a_base_is_compared_with_what_is_printed(rate: float, verdict: str) -> None:
    assert bounds.base(fit(rate), 0.56, 0.005) == verdict


@pytest.mark.parametrize(
    ("rate", "verdict"),
    [
        (3.747, CONTRADICTED), (3.749, HOLDS), (4.0, HOLDS), (4.251, HOLDS), (4.253, EXCEEDS),
        (0.0, CONTRADICTED), (NAN, NOT_RUN),
    ],
)  # fmt: skip
def test_an_order_is_compared_with_what_is_printed(rate: float, verdict: str) -> None:
    assert bounds.order(fit(rate), 4.0) == verdict


def test_a_rate_without_uncertainty_is_not_a_rate() -> None:
    assert bounds.order(fit(4.0, NAN), 4.0) == NOT_RUN
    assert bounds.base(fit(0.5, NAN), 0.56, 0.005) == NOT_RUN


@pytest.mark.parametrize(
    "large", [replace(fit(NAN), stays_large=True), replace(fit(4.0), relapse=True)]
)
def test_errors_that_stay_or_become_large_contradict_any_rate(large: Fit) -> None:
    assert bounds.order(large, 4.0) == CONTRADICTED
    assert bounds.base(large, 0.56, 0.005) == CONTRADICTED
    assert bounds.converges(large) == CONTRADICTED
    assert bounds.at_least_geometric(large, fit(0.5), fit(0.5)) == CONTRADICTED


def test_what_converges_has_an_order_above_zero() -> None:
    assert bounds.converges(fit(0.0021)) == HOLDS
    assert bounds.converges(fit(0.0019)) == CONTRADICTED
    assert bounds.converges(fit(NAN)) == NOT_RUN


def test_a_geometric_fall_is_below_one_and_does_not_slow_down() -> None:
    check = bounds.at_least_geometric
    assert check(fit(0.7), fit(0.7), fit(0.7)) == HOLDS
    assert check(fit(0.6), fit(0.7), fit(0.5)) == HOLDS
    assert check(fit(0.999), fit(0.7), fit(0.7)) == CONTRADICTED
    assert check(fit(0.7), fit(0.7), fit(0.72)) == CONTRADICTED
    assert check(fit(0.7), fit(NAN), fit(0.7)) == NOT_RUN


@pytest.mark.parametrize(
    ("rule", "inside", "outside"),
    [
        (lambda x: bounds.bound(x, 1.0), 1.0, 1.0000001),
        (lambda x: bounds.within(x, 0.5, 1.0), 0.5, 0.4999999),
        (lambda x: bounds.within(x, 0.5, 1.0), 1.0, 1.0000001),
    ],
)
def test_a_bound_holds_up_to_itself(
    rule: Callable[[float], str], inside: float, outside: float
) -> None:
    assert rule(inside) == HOLDS
    assert rule(outside) == CONTRADICTED
    assert rule(NAN) == NOT_RUN
    assert rule(math.inf) == NOT_RUN


def test_an_error_that_swings_does_not_grow() -> None:
    t = np.arange(400.0)
    seen = bounds.drift(t, 1e-3 * np.sin(0.37 * t))
    assert bounds.no_growth(seen, 1e-2) == HOLDS
    assert bounds.no_growth(seen, 1e-4) == CONTRADICTED


@pytest.mark.parametrize("growth", [1e-5, -1e-5])
def test_an_error_that_drifts_grows_though_it_is_within_its_bound(growth: float) -> None:
    t = np.arange(400.0)
    seen = bounds.drift(t, growth * t + 1e-4 * np.sin(0.37 * t))
    assert bounds.no_growth(seen, 1.0) == CONTRADICTED


def test_a_slow_trend_below_the_allowed_growth_is_still_a_trend() -> None:
    t = np.arange(400.0)
    seen = bounds.drift(t, 1e-3 * (1.0 + 3e-4 * t))
    assert seen.growth < bounds.GROWTH
    assert bounds.no_growth(seen, 1.0) == CONTRADICTED


def test_growth_of_rounding_errors_is_allowed_up_to_the_stated_level() -> None:
    t = np.arange(400.0)
    seen = bounds.drift(t, 1e-16 * t)
    assert bounds.no_growth(seen, 1.0, round_off=1e-13) == HOLDS
    assert bounds.no_growth(seen, 1.0, round_off=1e-15) == CONTRADICTED


def test_a_history_with_a_hole_or_too_short_is_not_judged() -> None:
    t = np.arange(40.0)
    error = np.ones(40)
    error[17] = NAN
    for seen in (bounds.drift(t, error), bounds.drift(t[:7], error[:7])):
        assert bounds.no_growth(seen, 10.0) == NOT_RUN
    assert bounds.no_growth(Drift(NAN, NAN, NAN, NAN), math.inf) == NOT_RUN


def test_no_error_at_all_does_not_grow() -> None:
    assert bounds.no_growth(bounds.drift(np.arange(9.0), np.zeros(9)), 0.0) == HOLDS


@pytest.mark.parametrize(
    ("worst", "verdict"), [(0.09, HOLDS), (0.11, CONTRADICTED), (NAN, NOT_RUN)]
)
def test_every_n_has_to_gain(worst: float, verdict: str) -> None:
    assert bounds.every_n_gains(fit(0.05), worst, 0.1) == verdict
    assert bounds.every_n_gains(fit(NAN), 0.05, 0.1) == NOT_RUN
    assert bounds.every_n_gains(replace(fit(0.05), relapse=True), 0.05, 0.1) == CONTRADICTED
