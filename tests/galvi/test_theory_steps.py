"""What theory says of steps: the theorems' bounds, and the stiffness of a problem's force."""

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.analysis.step_bounds import lagrange_constants
from galvi.analysis.theory import Z0
from tests.galvi.theory_pairs import KEPLER, OSCILLATOR, P, method


def test_the_bounds_on_the_step_are_those_of_the_theorems():
    """The oscillator has m = K = C_R = D = 1."""
    said = method().theory(OSCILLATOR, step=0.1)
    assert (said.lipschitz, said.frequency) == (1.0, 1.0)
    assert abs(said.unique_motion_step - Z0 / np.sqrt(3)) < 1e-15
    assert abs(said.unique_step - Z0 / np.sqrt(3) / said.friedrichs) < 1e-15
    assert abs(said.minimum_step - np.pi) < 1e-15
    assert abs(said.coercive_step - np.pi / np.sqrt(2)) < 1e-15
    assert abs(said.fixed_point_step - said.spectral_radius**-0.5) < 1e-15
    assert abs(said.contraction - 3 * 0.01 / Z0**2 * said.friedrichs**2) < 1e-15
    assert abs(said.spectral_contraction - 0.01 * said.spectral_radius) < 1e-16
    assert said.exists and said.minimizes and said.coercive and said.converges
    assert said.reasons == {}
    far = method().theory(OSCILLATOR, step=-20.0)
    assert far.step == -20.0
    assert not (far.exists or far.minimizes or far.coercive or far.converges)


@pytest.mark.parametrize(("degree", "limit"), [(2, 3.46), (4, 6.05), (8, 11.3), (16, 21.9)])
def test_fixed_point_iteration_ends_where_its_spectrum_says(degree, limit):
    """The oscillator's passes shrink or grow by h^2 rho(A): counted beside Newton's method."""
    gauss = galvi.Galerkin(P(degree), galvi.gauss(degree))
    step = gauss.theory(OSCILLATOR).fixed_point_step
    assert abs(step - limit) < 0.02
    A = gauss.table.A
    for h, grows in ((0.97 * step, False), (1.03 * step, True)):
        stages = np.linalg.matrix_power(-h * h * A, 400) @ np.ones(len(A))
        assert (np.max(np.abs(stages)) > 1.0) == grows


def test_an_explicit_method_needs_no_limit_of_passes():
    verlet = galvi.theory(P(1), galvi.lobatto(2), OSCILLATOR, 0.1)
    assert verlet.spectral_radius == 0.0 and verlet.fixed_point_step == np.inf
    assert verlet.spectral_contraction == 0.0 and verlet.converges


def test_the_bound_of_h_is_in_the_unit_of_time_and_at_most_1():
    inverse, most = lagrange_constants(P(4), galvi.gauss(5))
    said = method().theory(OSCILLATOR)
    assert abs(said.stage_step - 1 / (inverse * most)) < 1e-15
    soft = method().theory(OSCILLATOR, lipschitz=1e-6)
    assert soft.stage_step == 1.0 and soft.lipschitz == 1e-6


def test_the_constant_of_keplers_force_is_that_at_pericentre():
    said = method().theory(KEPLER, step=0.2)
    assert abs(said.lipschitz - 2 / 0.4**3) < 1e-12
    assert said.source == "estimated along the motion from t = 0 to 2"
    from_apocentre = replace(KEPLER, q0=[-1.6, 0.0], v0=[0.0, -0.5])
    assert method().theory(from_apocentre, step=0.01).lipschitz < 0.5
    assert abs(method().theory(from_apocentre, step=0.6).lipschitz / 31.25 - 1) < 0.02  # 2e-3
    given = method().theory(KEPLER, 0.2, lipschitz=31.25)
    assert given.source == "given" and abs(given.unique_step - said.unique_step) < 1e-12


def test_a_mass_matrix_and_a_change_of_coordinates_change_no_bound():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    mass, stiff = turn @ np.diag([1.0, 100.0]) @ turn.T, turn @ np.diag([4.0, 100.0]) @ turn.T
    chain = galvi.Canonical(mass, lambda q: 0.5 * q @ stiff @ q, lambda q: stiff @ q)
    said = method().theory(galvi.Problem(chain, [1.0, 0.5], [0.0, 0.0]), step=0.1)
    assert abs(said.frequency - 2.0) < 1e-6 and abs(said.lipschitz - 100.0) < 1e-4
    given = method().theory(galvi.Problem(chain, [1.0, 0.5], [0.0, 0.0]), lipschitz=100.0)
    assert abs(given.frequency - 10.0) < 1e-12  # the least mass is 1: safe, and not sharp


def test_heavy_and_light_bodies_are_compared_by_their_accelerations():
    """Mercury's pull of the Sun decides, whatever the masses are counted in."""
    said = galvi.theory(P(8), galvi.gauss(8), galvi.problems.solar_system(), 10.0)
    pericentre = 0.3075  # of Mercury, au; the force's Jacobian is 2 G M / r^3 there
    assert abs(said.frequency**2 / (2 * 2.9591e-4 / pericentre**3) - 1) < 0.02  # 0.002
    assert said.exists is False and said.converges is True


def quartic():
    return galvi.Canonical(
        1.0, lambda q: 0.25 * q[0] ** 4, lambda q: q**3, lambda q: 3.0 * q[None] ** 2
    )


def test_a_stiffness_that_is_0_at_the_start_is_found_along_the_motion():
    """v^2 / 2 + q^4 / 4 = 1/2: 3 q^2 is at most 3 sqrt 2 = 4.243."""
    problem = galvi.Problem(quartic(), [0.0], [1.0])
    for step in (1.0, 10.0, 1000.0):
        assert 0.97 * 3.0 * np.sqrt(2.0) < method().theory(problem, step).lipschitz < 4.28  # 4.234
    exactly_1, nearly = (method().theory(problem, step).lipschitz for step in (0.1, 0.1000001))
    assert exactly_1 == pytest.approx(nearly, rel=1e-3) and nearly > 1.0  # ten steps' duration
    said = method().theory(problem)
    assert said.lipschitz is None and "Give a step, or lipschitz" in said.reasons["lipschitz"]
    assert method().theory(problem, lipschitz=4.25).exists is None


def test_a_negative_step_looks_backwards():
    problem = replace(
        KEPLER, q0=[-1.0, 0.9], v0=[-0.6, -0.8]
    )  # towards pericentre, or away from it
    ahead, back = (method().theory(problem, step) for step in (0.2, -0.2))
    assert back.source.endswith("from t = 0 to -2") and ahead.source.endswith("from t = 0 to 2")
    mirrored = replace(problem, v0=-problem.v0)
    assert back.lipschitz == method().theory(mirrored, 0.2).lipschitz != ahead.lipschitz


def test_a_free_particle_may_take_any_step():
    free = galvi.Canonical(1.0, lambda q: 0.0, np.zeros_like, lambda q: np.zeros((1, 1)))
    said = method().theory(galvi.Problem(free, [0.0], [1.0]), step=1e6)
    assert said.exists and said.unique_step == np.inf and said.contraction == 0.0
    assert "any step      a step has exactly one solution" in str(said) and "inf" not in str(said)


def test_a_force_that_is_not_finite_has_no_bounds():
    broken = galvi.Canonical(1.0, lambda q: 0.0, lambda q: q * np.nan, lambda q: np.eye(1))
    said = method().theory(galvi.Problem(broken, [0.0], [1.0]), step=0.1)
    assert said.lipschitz is None and "not finite near the start" in said.reasons["unique_step"]
