"""Problems and their systems: derivatives against independent ones, and what cannot be changed."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi

ALL = [
    galvi.problems.harmonic_oscillator(),
    galvi.problems.kepler(0.6),
    galvi.problems.henon_heiles(),
    galvi.problems.fermi_pasta_ulam_tsingou(masses=4, alpha=0.25, beta=0.5),
    galvi.problems.solar_system(pluto=False),
]


def gravity(masses, G, q):
    """Accelerations by the textbook formula, one pair at a time; also for complex q."""
    out = np.zeros_like(q)
    for i in range(len(masses)):
        for j in range(len(masses)):
            if i != j:
                gap = q[j] - q[i]
                out[i] += G * masses[j] * gap / np.sum(gap * gap) ** 1.5
    return out


def by_differences(function, q, size=1e-5):
    columns = [(function(q + e) - function(q - e)) / (2 * size) for e in size * np.eye(q.size)]
    return np.array(columns).T


@pytest.mark.parametrize("problem", ALL, ids=lambda problem: problem.name)
def test_the_force_is_minus_the_slope_of_the_potential_and_its_slope_is_the_jacobian(problem):
    system, q0 = problem.system, problem.q0

    def potential(flat):
        return float(system.potential_energy(flat.reshape(q0.shape), np.zeros(())))

    def acceleration(flat):
        return system.acceleration(flat.reshape(q0.shape), 0.0).ravel()

    slope = by_differences(potential, q0.ravel())
    force = system.momentum(system.acceleration(q0, 0.0))
    assert np.allclose(force.ravel(), -slope, rtol=1e-5, atol=1e-6 * np.abs(force).max())
    jacobian = system.acceleration_jacobian(q0, 0.0)
    exact = by_differences(acceleration, q0.ravel())
    assert np.allclose(jacobian, exact, rtol=1e-6, atol=1e-8 * np.abs(jacobian).max())


def test_the_driven_oscillator_moves_as_its_equation_at_its_own_time():
    problem = galvi.problems.driven_oscillator()
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(7))
    run = galvi.integrate(problem, method, 0.05, 100)

    def right_side(t, y):
        return y[1], -y[0] - y[0] ** 3 + np.sin(1.5 * t)

    start, span = (problem.q0[0], problem.v0[0]), (problem.t0, problem.t0 + 5.0)
    end = solve_ivp(right_side, span, start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    assert problem.t0 != 0.0
    assert np.allclose([run.q[-1, 0], run.p[-1, 0]], end, atol=1e-9)


def test_ready_problems_start_in_motion_where_asked():
    assert galvi.problems.harmonic_oscillator(0.5).v0 == 0.5
    swing = galvi.problems.planar_pendulum(2.0, rate=-0.5)
    assert swing.v0 == -0.5
    assert dict(swing.parameters) == {"amplitude": 2.0, "rate": -0.5}


def test_gravity_is_that_of_the_textbook_and_so_is_its_derivative():
    rng = np.random.default_rng(1)
    masses, q = rng.uniform(0.5, 2, 4), rng.normal(size=(4, 3))
    system = galvi.NBody(masses, G=0.7)
    assert np.allclose(system.acceleration(q, 0.0), gravity(masses, 0.7, q), rtol=1e-14)
    shifted = (q + 1e-20j * unit.reshape(q.shape) for unit in np.eye(q.size))
    exact = np.array([gravity(masses, 0.7, z).imag.ravel() for z in shifted]).T / 1e-20
    assert np.allclose(system.acceleration_jacobian(q, 0.0), exact, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("bodies", [3, 10])
@pytest.mark.parametrize("dimension", [2, 3])
def test_newton_has_the_jacobian_of_a_few_bodies_and_of_many_their_own_blocks(bodies, dimension):
    rng = np.random.default_rng(4)
    system, q = galvi.NBody(rng.uniform(0.5, 2, bodies)), rng.normal(size=(bodies, dimension))
    field = system.force_kernel(dimension)
    assert field.width == (q.size if bodies == 3 else dimension)
    blocks = np.empty((q.size, field.width, 1))
    field.slope(q.reshape(-1, 1).copy(), np.zeros(1), field.constants, blocks)
    full = system.acceleration_jacobian(q, 0.0)
    for i in range(0, q.size, field.width):
        block = slice(i, i + field.width)
        tolerance = 1e-15 * np.abs(full[block, block]).max()
        assert np.allclose(blocks[block, :, 0], full[block, block], rtol=1e-13, atol=tolerance)


def test_a_missing_gradient_and_hessian_are_differenced():
    exact = galvi.problems.henon_heiles().system
    differenced = galvi.Canonical(1.0, exact.potential.py_func)
    for q in np.random.default_rng(2).normal(size=(5, 2)):
        gradients, hessians = (
            [getattr(system, f"potential_{name}")(q, 0.0) for system in (differenced, exact)]
            for name in ("gradient", "hessian")
        )
        assert np.allclose(*gradients, atol=1e-12) and np.allclose(*hessians, atol=1e-9)


def test_momenta_are_mass_times_velocity_for_every_kind_of_mass():
    v = np.array([[1.0, 2.0], [3.0, -1.0]])
    mass_matrix = np.array([[2.0, 0.5], [0.5, 1.0]])
    spring = galvi.LinearSpring()
    for mass, expected in (
        (3.0, 3.0 * v),
        ([2.0, 5.0], v * [2.0, 5.0]),
        (mass_matrix, v @ mass_matrix),
    ):
        system = galvi.Canonical(mass, spring)
        assert np.allclose(system.momentum(v), expected)
        assert np.allclose(system.velocity(system.momentum(v)), v)


def test_problems_cannot_be_changed_by_accident():
    problem = galvi.problems.kepler(0.1)
    with pytest.raises(ValueError, match="read-only"):
        problem.q0[0] = 7.0
    with pytest.raises(AttributeError):
        problem.t0 = 3.0
    with pytest.raises(TypeError):
        problem.parameters["eccentricity"] = 0.5
