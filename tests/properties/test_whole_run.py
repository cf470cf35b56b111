"""An error measured over a part is extrapolated only where the motion stays the same."""

import importlib
import math

import numpy as np
import pytest

import galvi
from galvi.recommend.extrapolation import turning_points
from references.closed_forms.kepler import KEPLER
from tests.properties.test_recommend import ORBIT, apocentre, recommend


def hilltop():
    """A problem with q = cosh(t) / 100: errors grow as e^t, whatever processor and step."""
    system = galvi.Canonical(1.0, lambda q: -0.5 * q[0] ** 2, lambda q: -q)
    return galvi.Problem(system, [0.01], [0.0])


# Errors near the one asked for differ between processors, too, by the order in which BLAS adds:
# what is expected here holds for any choice.


@pytest.mark.slow_cases(
    "problem0-100.0-options0-an error is not extrapolated to ",
    "problem1-1000.0-options1-an error is not extrapolated to ",
)
@pytest.mark.parametrize(
    ("problem", "duration", "options", "reason"),
    [
        (galvi.problems.kepler(0.999), 100.0, {}, "an error is not extrapolated to "),
        (galvi.problems.kepler(0.99), 1000.0, {"budget": 1e6}, "an error is not extrapolated to "),
        (apocentre(0.9), 1000.0, {"budget": 3e5}, "an error is not extrapolated to "),
        (apocentre(0.99), 1000.0, {"budget": 1e6}, "an error is not extrapolated to "),
        (apocentre(0.9), 1000.0, {"measured": 1.0}, "an error is not extrapolated to "),
        (apocentre(0.9), 100.0, {"measured": 1.0}, "turning points of a coordinate, and 6 are"),
        (apocentre(0.9), 200.0, {"measured": 10.0}, "turning points of a coordinate, and 6 are"),
        (
            hilltop(),
            50.0,
            {"measured": 8.0, "degrees": (2,)},
            "the error grew as t^",
        ),  # 5.3, of at most 3
        (ORBIT, 1e4, {"budget": 1e6, "measured": 200.0}, "does not fit into the budget"),
    ],
)
def test_an_error_seen_over_too_short_a_part_is_refused(problem, duration, options, reason):
    choice = recommend(problem, 1e-6, duration, **options)
    assert not choice.reached and choice.error == math.inf
    assert "It was measured over too short a part, the first " in choice.status
    assert reason in choice.status and choice.measured < 0.2 * duration


@pytest.mark.slow(beside="test_a_motion_that_changes_later_is_found_out")
def test_a_force_that_is_lost_later_is_found_out():
    spring = galvi.Canonical(
        1.0, lambda q: 0.5 * q[0] ** 2, lambda q: q if q[0] >= -0.5 else np.array([np.nan])
    )
    problem = galvi.Problem(spring, [1.0], [0.0])
    choice = recommend(problem, 1e-6, 50.0, measured=1.5, degrees=(6, 8))
    assert (
        not choice.reached
        and "a run over the whole duration failed. Stopped at step" in choice.status
    )
    by_time = galvi.recommend(problem, 1e-6, 1000.0, budget=1.0, degrees=(6, 8))
    assert not by_time.reached and by_time.error == math.inf


def late_force(potential, gradient):
    """A body in the plane whose force changes at x = 8, where it arrives at t = 33."""
    system = galvi.Canonical(
        1.0,
        lambda q: 0.5 * q[1] ** 2 + (potential(q[0]) if q[0] > 8.0 else 0.0),
        lambda q: np.array([gradient(q[0]) if q[0] > 8.0 else 0.0, q[1]]),
    )
    return galvi.Problem(system, [-25.0, 1.0], [1.0, 0.0])


@pytest.mark.slow_cases("problem1-later the energy error is")
@pytest.mark.parametrize(
    ("problem", "reason"),
    [
        (late_force(lambda x: -0.5 * (x - 8.0) ** 2, lambda x: 8.0 - x), "as fast"),
        (late_force(lambda x: 0.0, lambda x: -0.02), "later the energy error is"),
    ],
)
def test_a_motion_that_changes_later_is_found_out(problem, reason):
    choice = recommend(problem, 1e-4, 36.0, measured=24.0, degrees=(6,))
    assert not choice.reached and reason in choice.status


def test_without_the_run_over_the_whole_duration_it_would_be_misled(monkeypatch):
    monkeypatch.setattr(
        importlib.import_module("galvi.recommend.recommend"),
        "extrapolation_objection",
        lambda *_: "",
    )
    problem = apocentre(0.9)
    choice = recommend(problem, 1e-6, 1000.0, budget=3e5)
    run = galvi.integrate(problem, choice.method, choice.step, choice.steps)
    end = KEPLER.run(problem, 1000.0, {"samples": 1}).q[-1]
    # 1.7e-5 or 1.7e-3, by the last bits of the runs that are measured
    assert choice.reached and np.linalg.norm(run.q[-1] - end) > 10.0 * 1e-6


def test_turning_points_are_those_of_a_coordinate_that_moves():
    t = np.linspace(0.0, 10.0 * math.pi, 1001)
    noise = 1e-12 * (-1.0) ** np.arange(len(t))
    assert turning_points(np.stack([np.cos(t + 0.1), t, noise], axis=1)) == 10
    assert turning_points(np.stack([t, noise], axis=1)) == 0
    assert turning_points(np.zeros((2, 1))) == turning_points(np.zeros((9, 1))) == 0
