"""Fits find the rates of synthetic errors, with uncertainties that cover, and leave out errors
before convergence and at round-off."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, EXCEEDS, Base, Order
from benchmarks.statistics import convergence_fits

FLOOR = 1e-12


def noise(size: int, seed: int, spread: float = 0.3) -> np.ndarray:
    return np.exp(spread * np.random.default_rng(seed).standard_normal(size))


@given(
    base=st.floats(0.2, 0.8),
    power=st.sampled_from([0.0, 0.5, 1.5]),
    size=st.floats(1e-3, 1e2),
    seed=st.integers(0, 10_000),
)
def test_a_geometric_rate_is_found_also_beside_a_known_factor(
    base: float, power: float, size: float, seed: int
) -> None:
    n = np.arange(1.0, 150.0)
    errors = size * n**-power * base**n * noise(n.size, seed)
    fit = convergence_fits.geometric(n, errors, floor=FLOOR, power=(power, 0.0))
    assert fit.points >= convergence_fits.FEWEST_POINTS and fit.power == power
    assert abs(fit.rate - base) <= max(10.0 * fit.uncertainty, 1e-9)


def test_a_factor_that_is_left_out_lowers_the_base_beyond_its_uncertainty() -> None:
    """Its neglect gives the wrong verdict "better than claimed"."""
    n = np.arange(33.0, 62.0)
    errors = 50.0 * n**-1.5 * 0.745**n
    bare = convergence_fits.geometric(n, errors, floor=FLOOR)
    assert Base(0.745, 0.005).verdict(bare) == EXCEEDS
    with_power = convergence_fits.geometric(n, errors, floor=FLOOR, power=(1.5, 0.0))
    assert Base(0.745, 0.005).verdict(with_power) == ATTAINED
    assert with_power.evaluate(n) == pytest.approx(errors)


def test_an_exponent_known_to_within_a_range_adds_its_part() -> None:
    n = np.arange(16.0, 56.0)
    fits = [convergence_fits.geometric(n, 0.6**n, floor=1e-15, power=(g, 0.0)) for g in (0.0, 0.5)]
    wide = convergence_fits.geometric(n, 0.6**n, floor=1e-15, power=(0.25, 0.25))
    assert wide.uncertainty >= 0.9 * 0.5 * abs(fits[1].rate - fits[0].rate)
    assert abs(wide.rate - 0.6) < 2.0 * wide.uncertainty


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6))
def test_the_stated_errors_cover_orders_that_have_not_settled(seed: int) -> None:
    """C h^p (1 + a h / 2 + b h^2 / 2) with scatter: at most 20 of 100 orders are missed."""
    random, missed = np.random.default_rng(seed), 0
    h = 2.0 ** (-np.arange(2, 14) / 2)
    for _ in range(100):
        p, a, b = random.integers(1, 9), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
        scatter = np.exp(0.02 * random.standard_normal(h.size))
        errors = 0.1 * h**p * (1.0 + 0.5 * a * h + 0.5 * b * h**2) * scatter
        fit = convergence_fits.algebraic(h, errors, floor=1e-15)
        missed += abs(fit.rate - p) > 2.0 * fit.uncertainty
    assert missed <= 20


def test_scatter_does_not_meet_an_order() -> None:
    """Errors without an order have a large uncertainty, within which not every order lies."""
    h = np.array([0.25, 0.17, 0.125, 0.083, 0.0625, 0.046, 0.031])
    erratic = [1.9e-6, 2e-7, 2.7e-7, 1.8e-9, 5.2e-9, 1e-9, 3.1e-9]
    fit = convergence_fits.algebraic(h, erratic, floor=1e-14)
    assert fit.uncertainty > 0.5
    assert Order(fit.rate + 1.0).verdict(fit) == CONTRADICTED


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
        ([1.0, 1e-9, 2.0, 3.0, 4.0], True),
        ([1.0, 1e-9, 2.0, 3.0, 4.0, 1e-9], False),
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
    h = 2.0 ** -np.arange(2, 10)
    fit = convergence_fits.algebraic(h, 3.0 * h**2, floor=FLOOR)
    assert fit.evaluate(h) == pytest.approx(3.0 * h**2)


def test_the_halves_tell_a_power_from_a_geometric_fall() -> None:
    n = np.arange(10, 60)
    early, late = convergence_fits.halves(n, 0.7**n, floor=FLOOR)
    assert late.rate == pytest.approx(early.rate)
    early, late = convergence_fits.halves(n, 1.0 * n**-4.0, floor=FLOOR)
    assert late.rate > early.rate + 2.0 * (early.uncertainty + late.uncertainty)


def test_the_worst_ratio_is_that_of_errors_in_the_window() -> None:
    errors = [0.5, 1e-2, 1e-3, 5e-4, 1e-6, 1e-13, 1e-13]
    assert math.isclose(convergence_fits.worst_ratio(errors, floor=FLOOR), 0.5)
    assert math.isnan(convergence_fits.worst_ratio(errors[:3], floor=FLOOR))
    assert convergence_fits.worst_ratio(1.0 / np.arange(4.0, 40.0) ** 4, floor=FLOOR) > 0.89
