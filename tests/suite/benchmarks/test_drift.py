"""Drifts are seen as trends, as envelopes and beside random walks; stationary series do not drift,
random walks have exponent 1/2, and changes of level are found where they are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchmarks.checks.bounds import CONTRADICTED, HOLDS, NOT_RUN
from benchmarks.checks.series_bounds import NoGrowth
from benchmarks.statistics.change_points import FEWEST_POINTS, change_points, steps
from benchmarks.statistics.drift import LEAST_TIMES, drift, growth
from benchmarks.studies.round_off_participants import SAMPLED_HUNDREDTHS
from galvi.arrays import Array
from tests.suite.benchmarks.test_planted_measurements import RAMPS

SAMPLES = 8000


def verdict(errors: Array, limit: float = math.inf) -> str:
    return NoGrowth(limit).verdict(drift(np.arange(errors.size), errors))


def filtered(memory: float, noise: Array) -> Array:
    from scipy.signal import lfilter  # 0.4 s, in each process that collects the tests

    return lfilter([math.sqrt(1.0 - memory**2)], [1.0, -memory], noise)


@pytest.mark.parametrize("memory", [0.0, 0.9])
@pytest.mark.parametrize(
    "shape",
    [
        lambda a, phase: a @ np.cos(phase),
        lambda a, phase: (a @ np.cos(phase)) ** 2,
        lambda a, phase: a @ (1.0 + 0.6 * np.cos(phase)) ** -2,
        lambda a, phase: np.prod(1.0 + a[:, None] * np.cos(phase), axis=0),
    ],
    ids=["sum", "square", "distances", "product"],
)
def test_a_planted_drift_is_seen_and_stationary_runs_give_no_alarm(
    shape: Any, memory: float
) -> None:
    """Functions of two phases with incommensurate periods, and a little white or coloured noise. A
    beat slower than the run would be a trend to anyone: roots of integers have none."""
    rng = np.random.default_rng(1)
    for period in (2.9, 7.3, 31.0):
        phase = math.tau * np.sqrt([[2.0], [3.0]]) / period
        phase = phase * (np.arange(SAMPLES) + rng.uniform(0.0, SAMPLES, (2, 1)))
        errors = shape(rng.uniform(0.05, 1.0, 2), phase)
        errors = (errors - errors[0]) / np.ptp(errors)
        errors += 3e-3 * filtered(memory, rng.standard_normal(SAMPLES))
        assert verdict(errors) != CONTRADICTED
        for change in RAMPS.values():
            assert verdict(change(errors, np.linspace(0.0, 1.0, SAMPLES))) == CONTRADICTED


def test_noise_alone_is_no_drift_of_short_runs_either() -> None:
    noise = filtered(0.9, np.random.default_rng(2).standard_normal((100, 2000)))[:, 200:]
    assert sum(verdict(errors) == CONTRADICTED for errors in noise) == 0


# Single histories.


def test_an_error_that_swings_does_not_grow_and_a_slow_drift_is_one() -> None:
    t = np.arange(4000.0)
    swings = 1e-3 * np.sin(0.37 * t)
    assert verdict(swings, 1e-2) == HOLDS and verdict(swings, 1e-4) == CONTRADICTED
    for slope in (2e-8, -2e-8):  # 8 % of the swings over the run
        assert verdict(slope * t + swings, 1.0) == CONTRADICTED
    assert verdict(1e-3 * (1.0 + 3e-5 * t), 1.0) == CONTRADICTED  # without any swing
    assert verdict(swings * (1.0 - 3e-5 * t), 1.0) == HOLDS  # what decays does not grow


def test_a_run_too_short_to_tell_is_not_called_good_and_a_plain_drift_is_still_seen() -> None:
    t = np.arange(200.0)
    swings = np.sin(0.09 * t)
    measured = drift(t, swings)
    assert (
        NoGrowth(2.0).verdict(measured) == NOT_RUN
        and NoGrowth(0.5).verdict(measured) == CONTRADICTED
    )
    assert NoGrowth(2.0, conclusive=False).verdict(measured) == HOLDS
    assert NoGrowth(9.0).verdict(drift(t, t / 20.0 + swings)) == CONTRADICTED


def test_the_standard_errors_of_noise_are_the_scatter_of_its_changes() -> None:
    noise = np.random.default_rng(4).standard_normal((200, 2000))
    drifts = [drift(np.arange(2000.0), errors) for errors in noise]
    for name in ("trend", "growth"):
        scatter = np.std([getattr(estimate, name) for estimate in drifts])
        stated = np.mean([getattr(estimate, f"{name}_error") for estimate in drifts])
        assert stated == pytest.approx(scatter, rel=0.15)  # 0.02 and 0.03 were measured


def test_a_history_with_a_hole_or_too_short_is_not_judged_and_no_error_does_not_grow() -> None:
    t, error = np.arange(400.0), np.ones(400)
    assert NoGrowth(10.0).verdict(drift(t[: LEAST_TIMES - 1], error[: LEAST_TIMES - 1])) == NOT_RUN
    error[17] = math.nan
    assert NoGrowth(10.0).verdict(drift(t, error)) == NOT_RUN
    assert NoGrowth(0.0).verdict(drift(t, np.zeros(400))) == HOLDS
    with pytest.raises(ValueError, match="evenly spaced"):
        drift(t**2, np.ones(400))


# Errors that walk at random.

KEPT_TIMES = np.array(SAMPLED_HUNDREDTHS, dtype=float)
STEP = 1e-17


def walks(runs: int, seed: int, drift: float = 0.0) -> np.ndarray:
    """Errors (runs, times) that move by STEP at random, 50 times in each unit of time."""
    moves = np.random.default_rng(seed).standard_normal((runs, 100, 50)).sum(axis=2)
    return STEP * np.cumsum(moves, axis=1)[:, np.array(SAMPLED_HUNDREDTHS) - 1] + drift * KEPT_TIMES


def fitted_growths(seeds: range, drift: float = 0.0) -> list:
    return [growth(KEPT_TIMES, walks(32, seed, drift)) for seed in seeds]


def test_a_random_walk_has_exponent_one_half_within_its_uncertainty() -> None:
    fits = fitted_growths(range(20))
    deviations = np.array([(fit.exponent - 0.5) / fit.uncertainty for fit in fits])
    assert np.sqrt(np.mean(deviations**2)) < 1.6  # 1 if the uncertainty is right
    assert np.mean([fit.exponent for fit in fits]) == pytest.approx(0.5, abs=0.02)
    assert not any(fit.drifts for fit in fits)
    assert {fit.runs for fit in fits} == {32}


def test_a_drift_below_the_walk_s_own_size_is_caught() -> None:
    walk_at_end = STEP * np.sqrt(50.0 * KEPT_TIMES[-1])
    fits = fitted_growths(range(5), drift=2.0 * walk_at_end / KEPT_TIMES[-1])
    assert all(fit.drifts and fit.drift > 0.0 for fit in fits)
    assert all(fit.exponent > 0.6 for fit in fits)


def test_an_offset_and_a_common_oscillation_are_no_drift() -> None:
    errors = walks(32, 3) + 1e-16 * (1.0 + np.sin(40.0 * KEPT_TIMES))
    assert not growth(KEPT_TIMES, errors).drifts


def test_what_a_state_s_rounding_hides_is_left_out_of_the_fit() -> None:
    rng = np.random.default_rng(4)
    floor = 3e-16
    hidden = walks(200, 5) + floor * rng.standard_normal((200, KEPT_TIMES.size))
    assert growth(KEPT_TIMES, hidden).exponent < 0.35
    fit = growth(
        KEPT_TIMES, walks(200, 5) + 1e-17 * rng.standard_normal((200, KEPT_TIMES.size)), floor=1e-16
    )
    assert fit.first > KEPT_TIMES[0] and fit.last == KEPT_TIMES[-1]
    assert fit.exponent == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    "errors", [np.zeros((1, KEPT_TIMES.size)), np.full((4, KEPT_TIMES.size), np.nan)]
)
def test_one_run_or_a_failed_one_gives_no_exponent(errors: np.ndarray) -> None:
    fit = growth(KEPT_TIMES, errors)
    assert np.isnan(fit.exponent) and not fit.drifts


# ---- levels of a series


def series(*levels: tuple[float, int]) -> list[float]:
    random = np.random.default_rng(7)
    return [level * (1 + 0.02 * random.standard_normal()) for level, n in levels for _ in range(n)]


def with_outlier(values: list[float], k: int, value: float) -> list[float]:
    return [*values[:k], value, *values[k + 1 :]]


@pytest.mark.parametrize(
    ("values", "changes"),
    [
        (series((1.0, 12), (1.2, 12)), [12]),
        (series((1.0, 12), (0.8, 12)), [12]),
        (series((1.0, 12), (1.5, 12), (1.2, 12)), [12, 24]),
        ([1.0, math.nan, *series((1.0, 11), (1.5, 12)), math.nan], [13]),  # passed over
        (series((1.0, 30)), []),
        (series((1.0, 15), (1.02, 15)), []),  # a small shift
        (with_outlier(series((1.0, 20)), 10, 3.0), []),
        ([], []),
        ([1.0] * 30, []),
        ([1.0] * (FEWEST_POINTS - 1) + [2.0] * (FEWEST_POINTS - 1), []),  # too few
    ],
)
def test_a_change_is_found_where_it_is_and_nowhere_else(
    values: list[float], changes: list[int]
) -> None:
    assert change_points(values) == pytest.approx(changes, abs=len(changes) - 1 if changes else 0)


@pytest.mark.slow(beside="test_a_change_is_found_where_it_is_and_nowhere_else")
def test_noise_alone_is_rarely_a_change() -> None:
    """4 of 200 series of 30 values gave an alarm, none of the first 40; 0.05 allows 2."""
    random = np.random.default_rng(0)
    false_alarms = sum(
        bool(change_points(1 + 0.05 * random.standard_normal(30))) for _ in range(40)
    )
    assert false_alarms <= 2


def test_counts_are_exact_and_errors_have_a_tolerance() -> None:
    assert steps([5, 5, 6, 6, 5], 0.0) == [2, 4]
    assert steps([1e-9, 1.005e-9, 1.5e-9, math.nan, 1.5e-9], 0.01) == [2]
    assert steps([0.0, 0.0, 1.0], 0.0) == [2]
