"""What is said about bad input to Lagrangians and groups, and systems that are stored."""

import pickle
from functools import cache

import numba
import numpy as np
import pytest

import galvi
from tests.galvi.lagrangians import METHOD, MOMENTS, swinging

PRODUCT = galvi.Product((galvi.SO3(), galvi.Rn(2)))


@cache
def turning_run():
    return galvi.integrate(galvi.problems.free_rigid_body(), METHOD, 0.1, 1)


@cache
def swinging_run():
    return galvi.integrate(swinging(1.0), METHOD, 0.1, 1)


def complex_gradient(R):
    return (1.0 + 1j) * R


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (lambda: galvi.UniformGravity(1, (0, 0, 1), None), ValueError,
         r"g must be a finite real number; received None\. Give a number, or a vector"),
        (lambda: galvi.UniformGravity(1, (0, 0, 1), "down"), ValueError, "received 'down'"),
        (lambda: PRODUCT.join(np.eye(3)), ValueError,
         r"join needs one part for each of the 2 factors; received 1\."),
        (lambda: PRODUCT.join(np.eye(3), np.ones(3)), ValueError,
         r"part 1 must have shape \(2,\), .* as an element of Rn\(n=2\); received shape \(3,\)"),
        (lambda: PRODUCT.join(np.eye(3), 1.0), ValueError, r"received shape \(\)"),
        (lambda: PRODUCT.join(np.ones((4, 3, 3)), np.ones((5, 2))), ValueError,
         r"parts must have the same leading axes; received \[\(4,\), \(5,\)\]"),
        (lambda: galvi.nearest_rotation([]), ValueError, r"matrix must be square; .* shape \(0,\)"),
        (lambda: galvi.nearest_rotation(np.zeros((0, 0))), ValueError, r"shape \(0, 0\)"),
        (lambda: galvi.nearest_rotation([["a"]]), ValueError, "matrix must be an array of real"),
        (lambda: galvi.nearest_rotation(np.zeros((3, 3))), ValueError,
         "no nearest rotation is defined for a matrix of rank below 2"),
        (lambda: galvi.nearest_rotation(np.ones((3, 3))), ValueError, "no nearest rotation is"),
        (lambda: galvi.Problem(galvi.RigidBody(MOMENTS), np.zeros((3, 3)), MOMENTS), ValueError,
         r"q0 must be a rotation, .* Give a matrix with orthonormal columns\."),
        (lambda: galvi.rotations("x"), TypeError, "run must be a galvi.Trajectory; received 'x'"),
        (lambda: galvi.momentum_map(swinging_run()), ValueError,
         "a Lagrangian does not say how rotations and translations of space act .* use a galvi"),
        (lambda: galvi.linear_momentum(turning_run()), ValueError,
         r"no linear momentum of its own; use galvi\.momentum_map"),
        (lambda: galvi.integrate(galvi.Problem(
            galvi.RigidBody(MOMENTS, lambda R: 1.0, complex_gradient), np.eye(3), MOMENTS
        ), METHOD, 0.1, 1), ValueError,
         r"gradient must return an array of shape \(3, 3\), dV/dR, of real numbers; received num"),
        (lambda: galvi.integrate(galvi.Problem(
            galvi.RigidBody(MOMENTS, lambda R: 1.0, numba.njit(complex_gradient)), np.eye(3),
            MOMENTS,
        ), METHOD, 0.1, 1), ValueError, "of real numbers; received numbers of type complex128"),
    ],
)  # fmt: skip
def test_bad_input_is_answered_in_one_sentence(make, error, sentence):
    with pytest.raises(error, match=sentence):
        make()


def test_the_energy_of_a_lagrangian_at_no_times_is_empty():
    run = swinging_run()
    assert galvi.energy(run, []).shape == (0,)
    assert galvi.energy(run, [0.05]) == pytest.approx(galvi.energy(run)[:1], abs=1e-6)


@pytest.mark.parametrize(
    "system",
    [
        galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, (0.0, 0.0, 1.0))),
        galvi.RigidBody(MOMENTS, np.sum, explicit_time=True),
        galvi.FreeBody(1.0, MOMENTS),
        galvi.UniformGravity(1.0, (0.0, 0.0, 1.0)),
    ],
    ids=lambda system: type(system).__name__,
)
def test_a_pickled_system_comes_back_equal_and_read_only(system):
    copy = pickle.loads(pickle.dumps(system))
    for name, value in vars(system).items():
        if isinstance(value, np.ndarray):
            assert np.array_equal(getattr(copy, name), value)
            assert not getattr(copy, name).flags.writeable
    assert getattr(copy, "explicit_time", None) == getattr(system, "explicit_time", None)


@pytest.mark.skipif(not galvi.FAST, reason="a mass by differences is not exactly singular")
def test_the_velocities_that_change_no_momentum_are_named():
    system = galvi.Lagrangian(lambda q, v: 0.5 * (v[0] + 100.0 * v[1]) ** 2 - q @ q, galvi.Rn(2))
    problem = galvi.Problem(system, [1.0, 1.0], [0.3, 0.2])
    with pytest.raises(ValueError, match=r"degenerate .* along v\[0\] - 0\.01 v\[1\]\."):
        galvi.integrate(problem, METHOD, 0.1, 1)
