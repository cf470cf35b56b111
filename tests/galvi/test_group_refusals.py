"""Systems on groups that cannot be, and users' functions that fail: one sentence each."""

import numba
import numpy as np
import pytest

import galvi
from tests.galvi.group_bodies import (
    FOUR,
    SO3,
    bent,
    kinetic,
    start,
)


@pytest.mark.parametrize("plain", [True, False], ids=["python", "numba"])
@pytest.mark.parametrize("which", ["gradient", "slopes"])
def test_nan_from_a_users_function_during_the_run_is_a_failure(which, plain):
    def gradient(R):
        return 0.0 * R if R[0, 0] > 0.5 else np.nan * R

    def slopes(R, v):
        return np.concatenate((v, (0.0 if R[0, 0] > 0.5 else np.nan) * R.ravel()))

    if not plain:
        gradient, slopes = numba.njit(gradient), numba.njit(slopes)
    system = (
        galvi.RigidBody((1.0, 1.0, 1.0), bent, gradient, check=False)
        if which == "gradient"
        else galvi.Lagrangian(kinetic, SO3, slopes)
    )
    # turned about the vertical at unit speed, R_00 = cos t is below 0.5 from t = 1.047 on
    run = galvi.integrate(start(system, np.eye(3), [0.0, 0.0, 1.0]), FOUR, 0.1, 40)
    assert run.failed_step == 11 and not run.success
    assert run.status.startswith("Stopped at step 11 of 40, from t = 1: the force or the state")
    assert np.isfinite(run.q[:11]).all() and np.isnan(run.q[11:]).all()
    assert np.isnan(run.p[11:]).all() and np.isnan(run(1.05)).all()
