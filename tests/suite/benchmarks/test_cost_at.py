"""Costs at which an error is reached, between the steps at which it was measured."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.applications.brownout.cost_at import cost_at, over
from benchmarks.statistics.estimate import Estimate

COSTS = 100.0 * 1.1 ** np.arange(12)
EXACT = np.zeros(12)


@given(st.floats(1.0, 6.0), st.floats(120.0, 250.0), st.sampled_from([-1.0, 1.0]))
def test_a_power_law_is_found_between_the_points(power: float, cost: float, sign: float) -> None:
    errors = sign * 1e-3 * (cost / COSTS) ** power
    assert cost_at(1e-3, COSTS, errors, EXACT).value == pytest.approx(cost, rel=0.01)


def test_an_error_that_changes_sign_is_below_only_after_its_last_excess() -> None:
    found = cost_at(1.0, COSTS[:5], np.array([3.0, 0.5, -2.0, 0.0, 0.4]), EXACT[:5]).value
    assert found == pytest.approx(COSTS[2] * 1.1**0.5)


def test_the_uncertainty_is_that_of_the_errors() -> None:
    errors, own = np.array([3.0, 1.2, 0.7]), np.array([0.1, 0.02, 0.03])
    found = cost_at(1.0, COSTS[:3], errors, own)
    by = [
        (cost_at(1.0, COSTS[:3], errors + d, own).value - found.value) for d in 1e-4 * np.diag(own)
    ]
    assert found.uncertainty == pytest.approx(1e4 * math.hypot(*by), rel=1e-3)


@pytest.mark.parametrize(
    "errors",
    [[0.5, 0.4, 0.1], [3.0, 2.0, 1.1], [3.0, 2.0, math.nan], [3.0, 0.5, math.nan, 0.4], []],
)
def test_what_was_not_crossed_or_failed_below_has_no_cost(errors: list[float]) -> None:
    k = len(errors)
    assert math.isnan(cost_at(1.0, COSTS[:k], np.array(errors), EXACT[:k]).value)


def test_a_ratios_relative_errors_add_in_squares() -> None:
    found = over(Estimate(8.0, 0.8), Estimate(4.0, 0.3))
    assert found.value == 2.0
    assert found.uncertainty == pytest.approx(2.0 * math.hypot(0.1, 0.075))
