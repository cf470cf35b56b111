"""The stopping rule of the iteration of a law: sequences of changes and the passes they take."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from galvi.kernels.nystrom.solve import DIVERGED, GOING, NOT_FINITE, SOLVED
from galvi.lanes import stopping
from galvi.lanes.stopping import begin_countdown, count_down

ROUNDING, TOLERANCE = 2e-16, 2.0**-55


def passes(changes, tolerance=TOLERANCE):
    """The code at which the iteration ends, or GOING, and the number of changes up to it."""
    history, count = np.empty(stopping.HISTORY), 0
    begin_countdown(history)
    for change in np.array(changes):
        count += 1
        with np.errstate(all="ignore"):
            code = count_down(change, tolerance, history)
        if code != GOING:
            return code, count
    return GOING, count


def convergent_changes(rate, start, seed, length=190):
    """Changes that shrink by about ``rate`` each, down to a few rounding errors."""
    random = np.random.default_rng(seed)
    exact = start * rate ** np.arange(length) * np.exp(random.uniform(-0.3, 0.3, length))
    return np.maximum(exact, ROUNDING * random.integers(1, 4, length))


@given(
    rate=st.floats(0.01, 0.6),
    start=st.floats(1e-6, 1.0),
    seed=st.integers(0, 999),
    tolerance=st.sampled_from([2.0**-60, TOLERANCE, 1e-12, 1e-9]),
)
def test_as_many_passes_are_made_as_the_rate_asks_for(rate, start, seed, tolerance):
    code, count = passes(convergent_changes(rate, start, seed), tolerance)
    needed = 1 + np.log(tolerance * (1.0 - rate) / (rate * start)) / np.log(rate)
    assert code == SOLVED
    assert count >= 0.85 * needed - 1.0 and count <= 1.25 * needed + 4.0


def test_convergence_that_rests_for_some_passes_is_waited_for():
    resting_changes = np.repeat(1e-3 * 0.1 ** np.arange(14.0), 5)
    code, count = passes(resting_changes)
    assert code == SOLVED and resting_changes[count - 1] < 1e-13


def test_a_plateau_far_above_rounding_errors_is_no_solution_at_once(monkeypatch):
    plateau = [*(1e-2 * 0.1 ** np.arange(11.0)), *[2e-12] * 40]
    code, count = passes(plateau)
    assert code == SOLVED and count >= 11 + stopping.SLOW_PASSES
    # Planted: any plateau counts as rounding errors.
    monkeypatch.setattr(stopping, "SLOW_CONVERGENCE", 1.0)
    assert passes(plateau)[1] < 11 + stopping.SLOW_PASSES


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_ends_the_iteration(bad):
    assert passes([1e-2, 1e-3, bad, 1e-4]) == (NOT_FINITE, 3)


def test_growing_changes_end_the_iteration():
    assert passes(1e-3 * 1.5 ** np.arange(60.0))[0] == DIVERGED


@given(
    rate=st.floats(0.05, 0.5),
    start=st.floats(1e-12, 1e-11),
    tolerance=st.floats(4e-15, 1e-13),
)
def test_the_passes_of_a_geometric_sequence_leave_a_rest_at_the_tolerance(rate, start, tolerance):
    changes = start * rate ** np.arange(-4.0, 190.0)
    code, count = passes(changes, tolerance)
    remainders = changes * rate / (1.0 - rate)  # after each pass
    assert code == SOLVED and remainders[count - 1] <= 1.000001 * tolerance
    assert count < 6 or remainders[count - 2] >= 0.999999 * tolerance


def test_a_rate_is_that_of_two_passes_also_where_the_first_was_too_far_to_be_judged():
    """1e-5 is far from 1e-10; over both passes the rate to 0.9e-6 would be a tenth of its size,
    and 2e-9 would end the iteration: 2e-9 x 0.09 is more than what is left of the tolerance."""
    assert passes([1e-2, 1e-5, 0.9e-6, 2e-9], 1e-10) == (GOING, 4)
    assert passes([1e-2, 1e-5, 0.9e-6, 2e-9, 1e-13], 1e-10) == (SOLVED, 5)
