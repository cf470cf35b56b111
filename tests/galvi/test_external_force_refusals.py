"""What is no force, forces that fail or raise, and balances that lack what they need."""

import numpy as np

import galvi
from tests.galvi.forced_systems import FOUR, SPRING, START, compiled


def test_a_force_that_fails_on_the_way_leaves_nan_and_says_so():
    system = galvi.Canonical(1.0, SPRING, force=compiled(failing), timed_force=True)
    run = galvi.integrate(galvi.Problem(system, *START), FOUR, 0.25, 8)
    assert not run.success
    assert run.failed_step == 5
    assert np.all(np.isnan(run.q[5:])) and np.all(np.isfinite(run.q[:5]))
    assert "infinite or NaN" in run.status


def failing(q, v, t):
    return v * (np.nan if t > 1.0 else 0.0)
