"""Steps and samples read from a setting."""

from __future__ import annotations

import numpy as np
import pytest

from references.setting import fixed_steps, sample_times


def test_steps_must_divide_the_duration():
    assert fixed_steps(1.0, {"step": 0.1}).count == 10
    assert fixed_steps(1.0, {"step": 0.1 * (1 + 5e-10)}).count == 10
    for step in (0.3, 0.1 * (1 + 5e-9), 2.0, -0.1):
        with pytest.raises(ValueError, match=r"step must divide.*Choose step = duration / \d+"):
            fixed_steps(1.0, {"step": step})


@pytest.mark.parametrize("step", [0.0, float("nan"), float("inf"), "fast"])
def test_a_step_that_is_no_step_is_refused(step):
    with pytest.raises(ValueError, match=r"step must .*received"):
        fixed_steps(1.0, {"step": step})


def test_a_setting_without_a_step_is_refused():
    with pytest.raises(ValueError, match="needs a 'step'"):
        fixed_steps(1.0, {})


def test_saved_steps_hold_the_first_every_kth_and_the_last():
    assert fixed_steps(1.0, {"step": 0.1, "save_every": 4}).saved.tolist() == [0, 4, 8, 10]
    assert fixed_steps(1.0, {"step": 0.1, "save_every": 5}).saved.tolist() == [0, 5, 10]
    assert fixed_steps(1.0, {"step": 0.1, "save_every": 99}).saved.tolist() == [0, 10]
    with pytest.raises(ValueError, match="save_every must be a whole number"):
        fixed_steps(1.0, {"step": 0.1, "save_every": 0})


def test_times_are_those_of_the_steps_and_not_a_running_sum():
    steps = fixed_steps(1e4, {"step": 0.1})
    assert np.array_equal(steps.times(3.0), 3.0 + np.arange(100_001) * 0.1)


def test_samples_end_at_the_end():
    assert sample_times(1.0, -3.0, {"samples": 3}).tolist() == [1.0, 0.0, -1.0, -2.0]
    assert sample_times(0.0, 0.1, {}).tolist() == [0.0, 0.1]
    with pytest.raises(ValueError, match="samples must be a whole number"):
        sample_times(0.0, 1.0, {"samples": 1.5})
