"""What a user's function raises during a run reaches the caller, and NaN is a failure."""

import numba
import numpy as np
import pytest

import galvi
from tests.properties.group_bodies import FOUR, MOMENTS, SO3, bent, kinetic, start
from tests.properties.lagrangians import opaque

RN = galvi.Rn(1)


def raising(value):
    """A function that cannot be traced, until its 400th call with the value of its arguments."""
    calls = []

    def function(*qv):
        calls.append(1)
        if len(calls) > 400:
            raise LookupError("left the table")
        return value(*qv)

    return opaque(function)


def fenced(value, fence=0.42):
    """A function that raises where a coordinate is beyond the fence, and is not traced for that."""

    def function(q, *v):
        if np.ravel(q)[0] > fence:
            raise LookupError("left the table")
        return value(q, *v)

    return function


def point(**fields):
    given = {"potential": galvi.LinearSpring(), "gradient": None} | fields
    return galvi.Problem(galvi.Canonical(1.0, **given), [0.4], [0.5])


def turning(R):
    if R[0, 0] < 0.9:
        raise LookupError("left the table")
    return -R[2, 2]


PROBLEMS = {
    "gradient": lambda: point(gradient=fenced(lambda q: q)),
    "force": lambda: point(force=fenced(lambda q, v: 0.0 * v)),
    "Lagrangian": lambda: galvi.Problem(
        galvi.Lagrangian(fenced(lambda q, v: 0.5 * v @ v), RN), [0.4], [0.5]
    ),
    "potential of a body": lambda: start(galvi.RigidBody(MOMENTS, raising(lambda R: 0.0))),
    "that branches": lambda: start(galvi.RigidBody(MOMENTS, turning), np.eye(3)),
    "gradient of a body": lambda: start(
        galvi.RigidBody(MOMENTS, bent, raising(lambda R: 0.0 * R), check=False)
    ),
    "Lagrangian on a group": lambda: start(
        galvi.Lagrangian(raising(lambda R, v: 0.5 * np.sum(v**2)), SO3)
    ),
    "its slopes": lambda: start(
        galvi.Lagrangian(kinetic, SO3, raising(lambda R, v: np.concatenate([v, np.zeros(9)])))
    ),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_what_a_users_function_raises_reaches_the_caller(name):
    with pytest.raises(LookupError, match="left the table"):
        galvi.integrate(PROBLEMS[name](), FOUR, 0.1, 1000)


@pytest.mark.slow_cases("gradient-numba", "slopes-numba")
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
    assert run.failed_step == 11 and run.outcome.end is galvi.End.STEP_FAILED
    assert np.isfinite(run.q[:11]).all() and np.isnan(run.q[11:]).all()
    assert np.isnan(run.p[11:]).all() and np.isnan(run(1.05)).all()
