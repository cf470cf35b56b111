"""Lagrangians in any units, velocities from momenta, and starts far out or degenerate."""

import math
import pickle

import numpy as np
import pytest

import galvi
from tests.properties.lagrangians import METHOD, MOMENTS, opaque, swinging


def relativistic(c, slopes=False):
    def L(q, v):
        return -c * c * np.sqrt(1.0 - v @ v / c**2) - 0.5 * q @ q

    def slopes_of_L(q, v):
        return np.concatenate([v / np.sqrt(1.0 - v @ v / c**2), -q])

    return galvi.Lagrangian(opaque(L), galvi.Rn(2), opaque(slopes_of_L) if slopes else None)


def canonical_end():
    angle = galvi.Canonical(1.0, lambda q: -np.cos(q[0]), lambda q: np.sin(q))
    return galvi.integrate(galvi.Problem(angle, [1.0], [0.3]), METHOD, 0.25, 8).q[-1]


@pytest.mark.parametrize("l", [1e-12, 1e-4, 1e6])
def test_a_differenced_lagrangian_moves_alike_in_all_units(l):
    run = galvi.integrate(swinging(l), METHOD, 0.25, 8)
    assert run.success
    assert np.allclose(run.q[-1] / l, canonical_end(), rtol=0.0, atol=1e-10)  # 1e-11
    assert np.ptp(galvi.energy(run)) < 2e-11  # 9e-12, the method's


@pytest.mark.slow(beside="test_a_differenced_lagrangian_moves_alike_in_all_units")
def test_a_body_far_from_the_origin_flies_as_a_free_body():
    def L(q, v):
        return 0.5 * v[:3] @ (MOMENTS * v[:3]) + v[3:] @ v[3:] - 2.0 * 9.81 * q[2, 3]

    q0, v0 = np.eye(4), [0.3, 0.8, 0.5, 1.0, 2.0, 3.0]
    q0[:3, 3] = 1e3, 0.0, -2e2
    runs = [
        galvi.integrate(galvi.Problem(system, q0, v0), METHOD, 0.1, 1)
        for system in (
            galvi.Lagrangian(L, galvi.SE3()),
            galvi.FreeBody(2.0, MOMENTS, (0.0, 0.0, -9.81)),
        )
    ]
    assert runs[0].success
    assert np.allclose(runs[0].q[-1], runs[1].q[-1], rtol=1e-12, atol=1e-12)  # 4e-16


@pytest.mark.parametrize("v", [1.0, 1e-4, 1e-8, 1e-12, 0.0])
def test_a_small_velocity_has_an_exact_momentum(v):
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v + np.cos(q[0]), galvi.Rn(1))
    momentum = system.momentum(np.array([v]), np.array([0.7]))
    assert abs(momentum[0] - v) < 4e-12 * max(v, 1e-3)  # 3e-16 for the small ones


@pytest.mark.parametrize("q", [0.0, 6e-17, 1e-9, 1.0])
def test_a_constant_force_is_felt_at_the_origin_too(q):
    def L(q, v):
        return 0.5 * v @ v - q[0]

    system = galvi.Lagrangian(L, galvi.Rn(1))
    force = system.lagrangian_kernel().function(np.array([q]), np.array([0.0]))[1]
    assert abs(force + 1.0) < 1e-11


@pytest.mark.parametrize(("c", "slopes"), [(1.0, False), (1e-8, True)])
def test_relativistic_velocities_are_found_from_their_momenta(c, slopes):
    system = relativistic(c, slopes)
    problem = galvi.Problem(system, [c, 0.0], [0.0, 0.9 * c])
    run = galvi.integrate(problem, METHOD, 0.1, 5)
    energy = galvi.energy(run)
    assert run.success and np.isfinite(energy).all()
    assert np.ptp(energy) < 1e-10 * c * c  # 1e-12
    exact = c * c / np.sqrt(1.0 - 0.81) + 0.5 * c * c
    assert abs(energy[0] - exact) < 1e-10 * exact
    from_rest = system.velocity(problem.p0, problem.q0)
    assert np.allclose(from_rest, problem.v0, rtol=0.0, atol=1e-10 * c)


def test_the_velocity_of_a_momentum_that_no_velocity_has_is_missing():
    def L(q, v):
        return np.sqrt(1.0 + v @ v)  # |p| < 1

    system = galvi.Lagrangian(L, galvi.Rn(1), lambda q, v: np.append(v / np.sqrt(1 + v @ v), 0.0))
    assert np.isnan(system.velocity(np.array([1.5]), np.zeros(1))).all()
    assert system.velocity(np.array([0.6]), np.zeros(1))[0] == pytest.approx(0.75, rel=1e-13)


def test_very_different_masses_are_not_degenerate():
    system = galvi.Lagrangian(opaque(lambda q, v: 1e6 * v[0] ** 2 + 1e-7 * v[1] ** 2), galvi.Rn(2))
    run = galvi.integrate(galvi.Problem(system, [1.0, 0.0], [1.0, 0.9]), METHOD, 0.1, 5)
    assert np.allclose(run.q[-1], [1.5, 0.45], rtol=1e-12)
    assert np.allclose(run.p[-1], [2e6, 1.8e-7], rtol=1e-10)


def test_a_mass_matrix_with_nothing_on_its_diagonal_is_regular():
    system = galvi.Lagrangian(opaque(lambda q, v: v[0] * v[1] - q @ q), galvi.Rn(2))
    run = galvi.integrate(galvi.Problem(system, [1.0, 0.0], [1.0, 0.9]), METHOD, 0.1, 5)
    assert np.ptp(galvi.energy(run)) < 1e-11  # 2e-13


def test_a_lagrangian_that_raises_outside_its_domain_is_only_probed_inside():
    def L(q, v):
        return -math.sqrt(1.0 - v[0] ** 2) - 0.5 * q[0] ** 2

    def slopes(q, v):
        return np.array([v[0] / math.sqrt(1.0 - v[0] ** 2), -q[0]])

    exact = 0.9 / math.sqrt(1.0 - 0.81)
    for gradient in (None, slopes):
        system = galvi.Lagrangian(L, galvi.Rn(1), gradient)
        velocity = system.velocity(np.array([exact]), np.array([1.0]))
        assert abs(velocity[0] - 0.9) < 1e-10
        assert abs(system.momentum(np.array([1e-9]), np.array([1.0]))[0] - 1e-9) < 1e-14


def test_the_energy_of_a_lagrangian_at_no_times_is_empty():
    run = galvi.integrate(swinging(1.0), METHOD, 0.1, 1)
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
    with pytest.raises(ValueError, match=r"degenerate .* along v\[0\] - 0\.01 v\[1\], or"):
        galvi.Problem(system, [1.0, 1.0], [0.3, 0.2])
