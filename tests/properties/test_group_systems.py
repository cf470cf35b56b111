"""Systems on groups: torques and momenta, and their motion against that in coordinates."""

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures.matrix_group import MatrixGroup
from tests.agreement.on_groups import bulging
from tests.properties.group_bodies import (
    FOUR,
    MOMENTS,
    R0,
    SO3,
    TWIST,
    nonlinear_gradient,
    nonlinear_potential,
)
from tests.properties.group_matrices import element, title, vectors

SO2, SE2 = galvi.SO2(), galvi.SE2()
SIX = galvi.Polynomials(6), galvi.gauss(6)


def timed_potential(R, t):
    return np.cos(t) * np.sum(TWIST * R)


def timed_gradient(R, t):
    return np.cos(t) * TWIST


@pytest.mark.parametrize(
    ("potential", "gradient"),
    [
        (nonlinear_potential, nonlinear_gradient),
        (nonlinear_potential, None),
        (timed_potential, timed_gradient),
        (timed_potential, None),
        (galvi.UniformGravity(2.0, (0.1, -0.3, 0.8), (1.0, 2.0, -9.0)), None),
    ],
)
@given(v=vectors(SO3))
def test_the_torque_is_minus_the_slope_of_the_potential_along_the_group(potential, gradient, v):
    """By a complex step, which has no rounding."""
    R, time = element(SO3, v), (0.7,) * (potential is timed_potential)
    system = galvi.RigidBody(MOMENTS, potential, gradient, explicit_time=bool(time))
    assert system.potential_energy(R, 0.7) == pytest.approx(potential(R, *time), rel=1e-14)
    moved = [MatrixGroup(SO3).moved(R, 1e-30j * unit) for unit in np.eye(3)]
    expected = [-potential(g, *time).imag / 1e-30 for g in moved]
    assert np.allclose(system.torque(R, 0.7), expected, rtol=0.0, atol=3e-11)


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
        [0.4, 0.1],
        [0.8, -0.5],
    )
    system = problem.system
    by_hand = (problem.v0 @ problem.v0 + 1.0) * problem.v0 + [0.0, 0.4]
    assert np.allclose(problem.p0, by_hand, rtol=0.0, atol=1e-11)
    assert np.allclose(system.velocity(problem.p0, problem.q0), problem.v0, rtol=0.0, atol=1e-10)
    with pytest.raises(ValueError, match="momentum depends on the configuration; give q"):
        system.momentum(problem.v0)


def test_a_lagrangian_on_a_vector_space_is_chapter_two_to_round_off():
    problem = galvi.problems.kepler(0.6)

    def slopes(q, v):
        return np.concatenate((v, -q / np.sqrt(np.sum(q * q)) ** 3))

    def L(q, v):
        return 0.5 * np.sum(v * v) + 1.0 / np.sqrt(np.sum(q * q))

    expected = galvi.integrate(problem, FOUR, 0.1, 20)
    lagrangian_problem = galvi.Problem(
        galvi.Lagrangian(L, galvi.Rn(2), slopes), problem.q0, problem.v0
    )
    method = galvi.Galerkin(FOUR.space, FOUR.rule, galvi.Exponential())
    run = galvi.integrate(lagrangian_problem, method, 0.1, 20)
    assert np.allclose(run.q, expected.q, rtol=0.0, atol=2e-13)
    assert np.allclose(run.p, expected.p, rtol=0.0, atol=2e-13)
    times = np.linspace(0.0, 2.0, 50)
    assert np.allclose(run(times), expected(times), rtol=0.0, atol=2e-13)
    assert np.allclose(run.velocity(times), expected.velocity(times), rtol=0.0, atol=2e-12)
    assert np.allclose(galvi.energy(run), galvi.energy(expected), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("group", [SO2, SE2, galvi.Product((galvi.Rn(1), SO2))], ids=title)
def test_a_lagrangian_on_a_group_moves_as_in_its_angle_and_places(group):
    """With a mass that depends on both, and a kinetic energy that is not quadratic."""

    def of_the_body(q, v):
        return np.concatenate([v[:1], element(SO2, q).T @ v[1:]]) if group == SE2 else v

    def in_coordinates(q, v):
        return bulging(element(group, q), of_the_body(q, v))

    d = group.dimension
    q0, v0 = np.linspace(0.6, -0.8, d), np.linspace(1.1, 0.2, d)
    coordinate_problem = galvi.Problem(galvi.Lagrangian(in_coordinates, galvi.Rn(d)), q0, v0)
    start = element(group, q0), of_the_body(q0, v0)
    group_problem = galvi.Problem(galvi.Lagrangian(bulging, group), *start)
    in_angles, on_group = (
        galvi.integrate(problem, galvi.Galerkin(*SIX, galvi.Exponential()), 0.1, 5)
        for problem in (coordinate_problem, group_problem)
    )
    assert np.allclose(on_group.q, [element(group, q) for q in in_angles.q], rtol=0.0, atol=1e-11)
    assert np.allclose(galvi.energy(on_group), galvi.energy(in_angles), rtol=0.0, atol=1e-11)


def test_a_free_body_turns_as_a_rigid_body_and_flies_as_a_point():
    """In flight each of 20 steps rounds the moment of the linear momentum at 12 stages, up to 12.5
    times 100, in the chart at its start; Newton's method loses less."""
    method, g = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12)), np.array([0.5, 0.0, -9.81])
    problem = galvi.problems.free_body_se3(g=g)
    turning = galvi.integrate(galvi.problems.free_rigid_body(), method, 0.25, 20)
    run = galvi.integrate(problem, method, 0.25, 20)
    tolerance = 20 * 12 * 12.5 * 100.0 * 2.0**-53  # 1.1e-11 of 3.3e-11
    assert np.allclose(run.q[:, :3, :3], turning.q, rtol=0.0, atol=tolerance)
    assert np.allclose(run.p[:, :3], turning.p, rtol=0.0, atol=10 * tolerance)
    v0, t = problem.v0[3:], run.t[:, None]
    fallen, momenta = v0 * t + 0.5 * g * t**2, problem.system.mass * (v0 + g * t)
    allowed_fall = 1e-12 * (1.0 + np.abs(fallen).max())
    assert np.allclose(run.q[:, :3, 3], fallen, rtol=0.0, atol=allowed_fall)
    linear = galvi.linear_momentum(run)
    assert np.allclose(linear, momenta, rtol=0.0, atol=1e-12 * np.abs(momenta).max())
    energy = galvi.energy(run)  # that of turning changes by w times what p does
    allowed = allowed_fall + 10 * tolerance * np.linalg.norm(problem.v0[:3])
    assert np.allclose(energy, energy[0], rtol=0.0, atol=allowed)
