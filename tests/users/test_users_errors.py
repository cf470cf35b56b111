"""Errors that a user's function raises during a run reach the caller; NaN is a failure."""

import numpy as np
import pytest

import galvi
from tests.properties.group_bodies import FOUR, MOMENTS, SO3, kinetic, nonlinear_potential, start

RN = galvi.Rn(1)


def within(low, high, value):
    """A function that raises where q's first entry is outside (low, high); it cannot be traced."""

    def function(q, *v):
        if not low < np.ravel(q)[0] < high:
            raise LookupError("left the table")
        return value(q, *v)

    return function


def point(**fields):
    arguments = {"potential": galvi.LinearSpring(), "gradient": None} | fields
    return galvi.Problem(galvi.Canonical(1.0, **arguments), [0.4], [0.5])


def from_identity(system):
    return start(system, np.eye(3))


PROBLEMS = {
    "gradient": lambda: point(gradient=within(0.0, 0.42, lambda q: q)),
    "force": lambda: point(force=within(0.0, 0.42, lambda q, v: 0.0 * v)),
    "Lagrangian": lambda: galvi.Problem(
        galvi.Lagrangian(within(0.0, 0.42, lambda q, v: 0.5 * v @ v), RN), [0.4], [0.5]
    ),
    "potential of a body": lambda: from_identity(
        galvi.RigidBody(MOMENTS, within(0.9, 2.0, lambda R: -R[2, 2]))
    ),
    "gradient of a body": lambda: from_identity(
        galvi.RigidBody(
            MOMENTS, nonlinear_potential, within(0.9, 2.0, lambda R: 0.0 * R), check=False
        )
    ),
    "Lagrangian on a group": lambda: from_identity(
        galvi.Lagrangian(within(0.9, 2.0, lambda R, v: 0.5 * np.sum(v**2)), SO3)
    ),
    "its slopes": lambda: from_identity(
        galvi.Lagrangian(kinetic, SO3, within(0.9, 2.0, lambda R, v: np.append(v, np.zeros(9))))
    ),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_what_a_users_function_raises_reaches_the_caller(name):
    with pytest.raises(LookupError, match="left the table"):
        galvi.integrate(PROBLEMS[name](), FOUR, 0.1, 1000)


@pytest.mark.parametrize("which", ["gradient", "slopes"])
def test_nan_from_a_users_function_during_the_run_is_a_failure(which):
    def gradient(R):
        return 0.0 * R if R[0, 0] > 0.5 else np.nan * R

    def slopes(R, v):
        return np.concatenate((v, (0.0 if R[0, 0] > 0.5 else np.nan) * R.ravel()))

    system = (
        galvi.RigidBody((1.0, 1.0, 1.0), nonlinear_potential, gradient, check=False)
        if which == "gradient"
        else galvi.Lagrangian(kinetic, SO3, slopes)
    )
    # it turns about the vertical at unit speed: R_00 = cos t is below 0.5 from t = 1.047 on
    run = galvi.integrate(start(system, np.eye(3), [0.0, 0.0, 1.0]), FOUR, 0.1, 40)
    assert run.failed_step == 11 and run.outcome.end is galvi.End.STEP_FAILED
    assert np.isfinite(run.q[:11]).all() and np.isnan(run.q[11:]).all()
    assert np.isnan(run.p[11:]).all() and np.isnan(run(1.05)).all()
