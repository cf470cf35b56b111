"""Systems on groups that cannot be, and users' functions that fail: one sentence each."""

import numba
import numpy as np
import pytest

import galvi
from tests.galvi.group_bodies import (
    FOUR,
    MOMENTS,
    R0,
    SO3,
    SPIN,
    bent,
    bent_slope,
    kinetic,
    start,
)
from tests.galvi.lagrangians import opaque

NOT_FINITE = "potential and gradient must be finite at the start"
REMEDY = r" Give three positive moments, each at most the sum of the others, or such a matrix\."


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (lambda: galvi.RigidBody((1.0, -1.0, 1.0)), ValueError,
         r"inertia must be positive definite; received principal moments \[-1\.0, 1\.0, 1\.0\]\."
         + REMEDY),
        (lambda: galvi.RigidBody((0.0, 1.0, 1.0)), ValueError, "inertia must be positive definite"),
        (lambda: galvi.RigidBody((1.0, 1.0, 2.1)), ValueError,
         r"no body has the inertia \[1\.0, 1\.0, 2\.1\]: its largest moment exceeds the sum of the "
         r"others\." + REMEDY),
        (lambda: galvi.RigidBody([[2, 0.5, 0], [0, 2, 0], [0, 0, 2]]), ValueError,
         "inertia must be symmetric; received"),
        (lambda: galvi.RigidBody([1.0, 2.0]), ValueError,
         r"inertia must have shape \(3,\) or \(3, 3\); received shape \(2,\)"),
        (lambda: galvi.RigidBody(3.0), ValueError, r"received shape \(\)"),
        (lambda: galvi.RigidBody((1.0, np.nan, 1.0)), ValueError, "inertia must hold finite"),
        (lambda: galvi.RigidBody("abc"), ValueError, "inertia must be an array of real numbers"),
        (lambda: galvi.FreeBody(1.0, (1.0, 1.0, 2.1)), ValueError, "no body has the inertia"),
        (lambda: galvi.FreeBody(-1.0, MOMENTS), ValueError, "mass must be positive; received -1"),
        (lambda: galvi.FreeBody(1.0, MOMENTS, 9.81), ValueError, r"g must have shape \(3,\)"),
        (lambda: galvi.RigidBody(MOMENTS, 3), TypeError, "potential must be a function of R"),
        (lambda: galvi.RigidBody(MOMENTS, bent, 3), TypeError, "gradient must be a function of R"),
        (lambda: galvi.RigidBody(MOMENTS, gradient=bent_slope), ValueError,
         "a gradient needs its potential; received none"),
        (lambda: galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, SPIN), explicit_time=True),
         ValueError, r"explicit_time means functions of \(R, t\)"),
        (lambda: galvi.UniformGravity(0.0, SPIN), ValueError, "mass must be positive"),
        (lambda: galvi.UniformGravity(1.0, (0.0, 1.0)), ValueError, r"centre must have shape"),
        (lambda: galvi.UniformGravity(1.0, SPIN, np.ones(2)), ValueError, r"g must have shape"),
        (lambda: galvi.Problem(galvi.RigidBody(MOMENTS), 1.001 * R0, SPIN), ValueError,
         r"q0 must be a rotation, .* received \|R\^T R - I\| = 2\.0e-03\. The nearest rotation is"),
        (lambda: galvi.Problem(galvi.RigidBody(MOMENTS), R0, np.eye(3)), ValueError,
         r"v0 must have shape \(3,\); received shape \(3, 3\)\. v0 is the body velocity\."),
        (lambda: galvi.Problem(galvi.FreeBody(1.0, MOMENTS), R0, np.ones(6)), ValueError,
         "q0 must be a rigid motion"),
        (lambda: galvi.Problem(galvi.FreeBody(1.0, MOMENTS), np.eye(4), SPIN), ValueError,
         r"v0 must have shape \(6,\)"),
        (lambda: galvi.Lagrangian(3, SO3), TypeError, r"function must be a function of \(q, v\)"),
        (lambda: galvi.Lagrangian(bent, SO3, 3), TypeError, r"slopes must be a function of"),
        (lambda: galvi.Lagrangian(bent, 3), TypeError, r"group must be a group such as galvi.SO3"),
        (lambda: galvi.Lagrangian(bent, galvi.SO3), TypeError, "group must be a group such as"),
        (lambda: galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), galvi.Exponential), TypeError,
         r"chart must be a chart such as galvi\.Cayley\(\); received <class"),
        (lambda: galvi.Galerkin(galvi.Polynomials, galvi.gauss(2)), TypeError,
         r"space must be a space such as galvi\.Polynomials\(8\); received <class"),
        (lambda: galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), 0), TypeError,
         r"chart must be a chart such as"),
    ],
)  # fmt: skip
def test_systems_that_cannot_be_are_refused_in_one_sentence(make, error, sentence):
    with pytest.raises(error, match=sentence):
        make()


@pytest.mark.parametrize(
    ("system", "sentence"),
    [
        (galvi.RigidBody(MOMENTS, lambda R: np.nan), NOT_FINITE),
        (galvi.RigidBody(MOMENTS, bent, lambda R: np.inf * R), NOT_FINITE),
        (galvi.RigidBody(MOMENTS, lambda R: R), r"potential must return a number; received an arr"),
        (galvi.RigidBody(MOMENTS, lambda R: None), "potential must return a real number; received"),
        (galvi.RigidBody(MOMENTS, lambda R: 1j), "potential must return a real number; received"),
        (galvi.RigidBody(MOMENTS, bent, lambda R: R[0]),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(3,\)"),
        (galvi.RigidBody(MOMENTS, bent, numba.njit(lambda R: R[0])),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(3,\)"),
        (galvi.RigidBody(MOMENTS, bent, numba.njit(lambda R: R[:2] + 0.0)),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(2, 3\)"),
        (galvi.Lagrangian(lambda q, v: np.nan, SO3), "the Lagrangian must return a finite number"),
        (galvi.Lagrangian(lambda q, v: v, SO3), "the Lagrangian must return a number; received an"),
        (galvi.Lagrangian(lambda q, v: "a", SO3), "the Lagrangian must return a real number; rec"),
        (galvi.Lagrangian(lambda q, v: v[0] ** 2 + v[1] ** 2, SO3),
         r"the Lagrangian is degenerate at the start: d2L/dv2 is singular, with eigenvalues"),
        (galvi.Lagrangian(lambda q, v: 3.0 * v[0], SO3), "the Lagrangian is degenerate"),
        (galvi.Lagrangian(kinetic, SO3, lambda q, v: v),
         r"slopes must return dL/dv and dL/dq in an array of shape \(12,\); received shape \(3,\)"),
        (galvi.Lagrangian(kinetic, SO3, numba.njit(lambda q, v: v + 0.0)), "slopes must return"),
        (galvi.Lagrangian(kinetic, SO3, lambda q, v: np.full(12, np.nan)),
         "the derivatives of the Lagrangian must be finite at the start"),
    ],
)  # fmt: skip
def test_functions_that_cannot_be_used_are_refused_before_the_first_step(system, sentence):
    problem = start(system)
    with pytest.raises(ValueError, match=sentence):
        galvi.integrate(problem, FOUR, 0.1, 3)
    with pytest.raises(ValueError, match=sentence):
        galvi.integrate_many([problem], FOUR, 0.1, 3)


@pytest.mark.parametrize("which", ["potential", "gradient", "function", "slopes"])
def test_what_a_users_function_raises_reaches_the_caller(which):
    calls = []

    def raises(*qv):
        calls.append(1)
        if len(calls) > 400:
            raise LookupError("left the table")
        if which == "slopes":
            return np.concatenate([qv[1], np.zeros(9)])
        return {"gradient": 0.0 * qv[0], "function": 0.5 * np.sum(qv[-1] ** 2)}.get(which, 0.0)

    called = opaque(raises)
    systems = {
        "potential": lambda: galvi.RigidBody(MOMENTS, called),
        "gradient": lambda: galvi.RigidBody(MOMENTS, bent, called, check=False),
        "function": lambda: galvi.Lagrangian(called, SO3),
        "slopes": lambda: galvi.Lagrangian(kinetic, SO3, called),
    }
    with pytest.raises(LookupError, match="left the table"):
        galvi.integrate(start(systems[which]()), FOUR, 0.1, 1000)


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
