"""Torques and momenta of systems on groups against derivatives of their energies."""

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

import galvi
from galvi.charts.chart import place
from galvi.systems.finite_differences import WEIGHTS
from tests.properties.group_bodies import MOMENTS, R0, SO3, TWIST, bent, bent_slope, run
from tests.properties.group_matrices import element, vectors


def timed(R, t):
    return np.cos(t) * np.sum(TWIST * R)


def timed_slope(R, t):
    return np.cos(t) * TWIST


def along(function, group, g, a, nudge=2.0**-7):
    """The derivative of function(g) along g hat(e_a), by differences of order eight."""
    unit = np.eye(group.dimension)[a]
    return sum(
        weight / nudge
        * (function(place(galvi.Exponential(), group, g, k * nudge * unit))
           - function(place(galvi.Exponential(), group, g, -k * nudge * unit)))
        for k, weight in enumerate(WEIGHTS, start=1)
    )  # fmt: skip


@pytest.mark.parametrize(
    "system",
    [
        galvi.RigidBody(MOMENTS, bent, bent_slope),
        galvi.RigidBody(MOMENTS, bent),
        galvi.RigidBody(MOMENTS, galvi.UniformGravity(2.0, (0.1, -0.3, 0.8), (1.0, 2.0, -9.0))),
        galvi.RigidBody(MOMENTS),
        galvi.RigidBody(MOMENTS, timed, timed_slope, explicit_time=True),
        galvi.RigidBody(MOMENTS, timed, explicit_time=True),
    ],
)
@given(v=vectors(SO3))
def test_the_torque_is_minus_the_slope_of_the_potential_along_the_group(system, v):
    R, t = element(SO3, v), 0.7

    def potential(R):
        return float(system.potential_energy(R, np.array(t)))

    expected = [-along(potential, SO3, R, a) for a in range(3)]
    assert np.allclose(system.torque(R, t), expected, rtol=0.0, atol=3e-11)


def test_the_weight_is_the_product_of_mass_gravity_and_height():
    gravity = galvi.UniformGravity(2.0, (0.0, 0.0, 0.5))
    assert np.array_equal(gravity.g, [0.0, 0.0, -9.81])
    assert gravity(np.eye(3)) == pytest.approx(2.0 * 9.81 * 0.5)
    assert gravity(R0) == pytest.approx(2.0 * 9.81 * (0.5 * R0[2, 2]))
    body = galvi.RigidBody(MOMENTS, gravity)
    upside = Rotation.from_euler("x", 0.3).as_matrix()  # it falls on to the side it leans to
    assert body.torque(upside, 0.0)[0] == pytest.approx(2.0 * 9.81 * 0.5 * np.sin(0.3))


def test_momentum_and_velocity_of_a_lagrangian_undo_each_other():
    problem = galvi.Problem(
        galvi.Lagrangian(lambda q, v: 0.25 * (v @ v) ** 2 + 0.5 * v @ v + q[0] * v[1], galvi.Rn(2)),
        [0.4, 0.1], [0.8, -0.5],
    )  # fmt: skip
    system = problem.system
    by_hand = (problem.v0 @ problem.v0 + 1.0) * problem.v0 + [0.0, 0.4]
    assert np.allclose(problem.p0, by_hand, rtol=0.0, atol=1e-11)
    assert np.allclose(system.velocity(problem.p0, problem.q0), problem.v0, rtol=0.0, atol=1e-10)
    with pytest.raises(ValueError, match="momentum depends on the configuration; give q"):
        system.momentum(problem.v0)


@pytest.mark.slow(
    beside="test_group_orders.py::test_a_wrong_torque_is_caught_by_the_truth_and_by_the_energy"
)
def test_a_wrong_gradient_is_caught_by_the_differences_and_by_the_energy():
    wrong = galvi.RigidBody(MOMENTS, bent, lambda R: bent_slope(R) + 1e-5 * TWIST.T)
    expected = [-along(bent, SO3, R0, a) for a in range(3)]
    assert not np.allclose(wrong.torque(R0, 0.0), expected, rtol=0.0, atol=1e-7)
    drift = [np.ptp(galvi.energy(run(system, step=0.05))) for system in (
        galvi.RigidBody(MOMENTS, bent, bent_slope), wrong)]  # fmt: skip
    assert drift[0] < 1e-9 < 1e-7 < drift[1]
