"""States between the steps of a run in the Kepler frame, where a body passes close by another."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from references.rebound.ias15 import IAS15

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
G = 0.01720209895**2
FRAME = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), chart=galvi.KeplerFrame())
# A meteoroid that passes the Earth at 26,000 km with 8.5 km/s at t = 24.5 days
METEOROID = galvi.Problem(
    galvi.NBody([1.0, 3.003e-6, 0.0], G),
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.054739257525, -0.018119104481, 0.104431693901]],
    [
        [0.0, 0.0, 0.0],
        [0.0, 0.01720212477893, 0.0],
        [-0.00248197063638, 0.01785420576982, -0.00402509261234],
    ],
)


@pytest.mark.slow(beside="test_states_of_a_completed_run_are_never_nan")
def test_states_and_events_of_a_run_through_a_passage_are_numbers_and_right() -> None:
    """Five of its states were NaN, and the event ended with a ValueError."""
    run = galvi.integrate(METEOROID, FRAME, 20.0, duration=60.0)
    assert run.success
    times = np.linspace(0.0, 60.0, 121)
    q, p = galvi.states_at(run, times)
    assert np.all(np.isfinite(q)) and np.all(np.isfinite(p))
    truth = IAS15.run(METEOROID, 60.0, {"samples": 120})
    assert np.max(np.abs(q - truth.q)) < 1e-7
    events = galvi.find_events(run, galvi.events.closest_approach(1, 2))
    assert len(events) == 1
    there = IAS15.run(METEOROID, float(events.t[0]), {"samples": 1})
    gap, speed = (x[-1, 2] - x[-1, 1] for x in (there.q, there.v))
    assert events.value[0] == pytest.approx(np.linalg.norm(gap), rel=1e-5)
    assert abs(gap @ speed) < 1e-3 * np.linalg.norm(gap) * np.linalg.norm(speed)


@pytest.mark.slow_cases("10.0")
@pytest.mark.parametrize("step", [10.0, 5.0])
def test_states_of_a_completed_run_are_never_nan(step: float) -> None:
    run = galvi.integrate(METEOROID, FRAME, step, duration=60.0)
    for part in galvi.states_at(run, np.linspace(0.0, 60.0, 61)):
        assert not run.success or np.all(np.isfinite(part))
