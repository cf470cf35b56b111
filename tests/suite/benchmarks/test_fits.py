"""Fits find the rate of synthetic errors, and leave out what is not convergence."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as student

from benchmarks.statistics import convergence_fits

FLOOR = 1e-12


def noise(size: int, seed: int, spread: float = 0.3) -> np.ndarray:
    return np.exp(spread * np.random.default_rng(seed).standard_normal(size))


@given(base=st.floats(0.2, 0.8), size=st.floats(1e-3, 1e2), seed=st.integers(0, 10_000))
def test_a_geometric_rate_is_found_within_its_uncertainty(
    base: float, size: float, seed: int
) -> None:
    n = np.arange(1, 150)
    errors = size * base**n * noise(n.size, seed)
    fit = convergence_fits.geometric(n, errors, floor=FLOOR)
    assert fit.points >= convergence_fits.LEAST
    assert abs(fit.rate - base) <= max(10.0 * fit.uncertainty, 1e-9)


@given(order=st.integers(1, 12), size=st.floats(1e-2, 1e2), seed=st.integers(0, 10_000))
def test_an_order_is_found_within_its_uncertainty(order: int, size: float, seed: int) -> None:
    h = 2.0 ** (-np.arange(0, 30) / 2)
    errors = size * h**order * noise(h.size, seed, 0.05)
    fit = convergence_fits.algebraic(h, errors, floor=1e-14)
    assert abs(fit.rate - order) <= max(10.0 * fit.uncertainty, 1e-9)


@given(seed=st.integers(0, 10_000))
def test_the_plateau_of_round_off_is_left_out(seed: int) -> None:
    n = np.arange(1, 61)
    errors = 0.5**n + 1e-13 * noise(n.size, seed, 1.0)
    fit = convergence_fits.geometric(n, errors, floor=FLOOR)
    assert fit.rate == pytest.approx(0.5, abs=0.02)
    assert errors[int(fit.window[1]) - 1] > FLOOR >= errors[int(fit.window[1])]


def test_the_part_before_convergence_is_left_out() -> None:
    h = 2.0 ** (-np.arange(0, 20) / 2)
    errors = 1e-2 * h**4 / (h**2 + 0.01)  # order 2 above h = 0.1, order 4 below
    fit = convergence_fits.algebraic(h, errors, floor=FLOOR)
    assert fit.rate == pytest.approx(4.0, abs=0.1)
    assert fit.window[0] < 0.1


def test_an_error_that_stagnates_above_round_off_spoils_the_rate() -> None:
    n = np.arange(1, 60)
    fit = convergence_fits.geometric(n, 0.5**n + 1e-6, floor=FLOOR)
    assert fit.rate > 0.9


def test_large_errors_and_failed_runs_before_convergence_are_left_out() -> None:
    n = np.arange(1, 31)
    errors = 0.5**n
    errors[2], errors[5], errors[7] = 1e30, math.inf, math.nan
    fit = convergence_fits.geometric(n, errors, floor=1e-12)
    assert fit.rate == pytest.approx(0.5)
    assert fit.window[0] >= 9
    assert not fit.relapse


@pytest.mark.parametrize("wild", [1.0, math.inf, math.nan])
def test_a_wild_run_among_converged_ones_is_a_relapse(wild: float) -> None:
    n = np.arange(1, 31)
    errors = 0.5**n
    errors[10] = wild
    assert convergence_fits.geometric(n, errors, floor=1e-12).relapse
    assert convergence_fits.algebraic(1.0 / n, errors, floor=1e-12).relapse
    errors[3:] = wild
    assert not convergence_fits.geometric(n, errors, floor=1e-12).relapse


@pytest.mark.parametrize("errors", [[], [0.01], [0.01, 0.001], [1.0, 2.0, 3.0], [math.nan] * 5])
def test_fewer_than_three_points_give_no_rate(errors: list[float]) -> None:
    for fit in (
        convergence_fits.geometric(range(len(errors)), errors, floor=FLOOR),
        convergence_fits.algebraic([0.5**k for k in range(len(errors))], errors, floor=FLOOR),
        *convergence_fits.halves(range(len(errors)), errors, floor=FLOOR),
    ):
        assert math.isnan(fit.rate) and math.isnan(fit.uncertainty) and fit.points == 0


@pytest.mark.parametrize(
    ("errors", "stays_large"),
    [
        ([2.0, 1.5, 1.6, 1.6], True),
        ([2.0, math.nan, 1.5, 1.6], True),
        ([math.nan] * 4, False),
        ([1.6, 1.6], False),
        ([1e-15, 1e-16, 1e-16], False),
    ],
)
def test_errors_that_stay_large_are_told_from_missing_ones(
    errors: list[float], stays_large: bool
) -> None:
    fit = convergence_fits.geometric(range(len(errors)), errors, floor=FLOOR)
    assert fit.points == 0
    assert fit.stays_large is stays_large


def test_errors_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="increase"):
        convergence_fits.geometric([1, 3, 2], [1e-2, 1e-3, 1e-4], floor=FLOOR)


def test_a_fit_evaluates_to_its_line() -> None:
    n, h = np.arange(3, 20), 2.0 ** -np.arange(2, 10)
    assert convergence_fits.geometric(n, 7.0 * 0.4**n, floor=FLOOR).evaluate(n) == pytest.approx(
        7.0 * 0.4**n
    )
    assert convergence_fits.algebraic(h, 3.0 * h**2, floor=FLOOR).evaluate(h) == pytest.approx(
        3.0 * h**2
    )


def test_the_uncertainty_is_that_of_the_slope_and_of_the_choice_of_the_window() -> None:
    n = np.arange(10, 20, dtype=float)
    y = np.log(0.5) * n + 0.1 * (-1.0) ** n
    slopes, spreads, widths = [], [], []
    for start in range(6):
        slope = np.polyfit(n[start:], y[start:], 1, cov="unscaled")
        rest = y[start:] - np.polyval(slope[0], n[start:])
        freedom = rest.size - 2
        slopes.append(slope[0][0])
        spreads.append(math.sqrt(slope[1][0, 0] * (rest @ rest) / freedom))
        widths.append(spreads[-1] * student.ppf(0.975, freedom))
    others = np.average((np.array(slopes) - slopes[0]) ** 2, weights=1.0 / np.square(widths))
    fit = convergence_fits.geometric(n, np.exp(y), floor=FLOOR)
    assert fit.points == 10
    assert fit.uncertainty == pytest.approx(fit.rate * math.hypot(spreads[0], math.sqrt(others)))


def test_the_halves_tell_a_power_from_a_geometric_fall() -> None:
    n = np.arange(10, 60)
    early, late = convergence_fits.halves(n, 0.7**n, floor=FLOOR)
    assert late.rate == pytest.approx(early.rate)
    early, late = convergence_fits.halves(n, 1.0 * n**-4.0, floor=FLOOR)
    assert late.rate > early.rate + 2.0 * (early.uncertainty + late.uncertainty)


def test_a_fall_holds_all_that_is_said_of_errors_in_n() -> None:
    n = np.arange(4.0, 20.0)
    errors = 0.5**n
    decay = convergence_fits.decay(n, errors, floor=FLOOR)
    assert decay.fit == convergence_fits.geometric(n, errors, floor=FLOOR)
    assert (decay.early, decay.late) == convergence_fits.halves(n, errors, floor=FLOOR)
    assert math.isclose(decay.worst, 0.5) and decay.smallest == errors[-1]
    assert math.isnan(convergence_fits.decay([], [], floor=FLOOR).smallest)


def test_the_worst_ratio_is_that_of_errors_in_the_window() -> None:
    errors = [0.5, 1e-2, 1e-3, 5e-4, 1e-6, 1e-13, 1e-13]
    assert math.isclose(convergence_fits.worst_ratio(errors, floor=FLOOR), 0.5)
    assert math.isnan(convergence_fits.worst_ratio(errors[:3], floor=FLOOR))
    assert convergence_fits.worst_ratio(1.0 / np.arange(4.0, 40.0) ** 4, floor=FLOOR) > 0.89


def test_errors_without_a_fit_stay_large_if_the_last_of_them_are():
    few, h = [1.0, 1e-9, 2.0, 3.0, 4.0], [0.5**k for k in range(6)]
    for errors, large in ((few, True), ([*few, 1e-9], False)):
        fit = convergence_fits.algebraic(h[: len(errors)], errors, floor=1e-3)
        assert np.isnan(fit.rate) and fit.stays_large is large
