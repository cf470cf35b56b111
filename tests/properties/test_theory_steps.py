"""Theory of steps: the bounds of the theorems, and the Lipschitz constant of a problem's force."""

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.analysis.step_bounds import Z0, lagrange_constants
from tests.properties.theory_pairs import KEPLER, OSCILLATOR, P, method


def radius(galerkin):
    """rho(A) of the method's tableau."""
    return np.max(np.abs(np.linalg.eigvals(galerkin.table.A)))


def test_the_bounds_on_the_step_are_those_of_the_theorems():
    """The oscillator has m = K = 1."""
    theory = method().theory(OSCILLATOR, step=0.1, lipschitz=1.0)
    at_start = method().theory(OSCILLATOR, step=0.1)
    assert at_start.lipschitz == 1.0 and at_start.unique_step == theory.unique_step
    assert at_start.exists is at_start.converges is None  # the constant may be larger elsewhere
    assert abs(theory.unique_step - Z0 / np.sqrt(3) / theory.friedrichs) < 1e-15
    assert abs(theory.fixed_point_step - radius(method()) ** -0.5) < 1e-15
    assert theory.exists and theory.converges
    assert theory.no_bounds == ""
    long_step = method().theory(OSCILLATOR, step=-20.0)
    assert long_step.step == -20.0
    assert not (long_step.exists or long_step.converges)


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
    assert verlet.fixed_point_step == np.inf
    assert verlet.converges and "any step      fixed-point" in str(verlet)
    assert "inf" not in str(verlet)


def test_the_bound_of_h_is_in_the_unit_of_time_and_at_most_1():
    inverse, largest = lagrange_constants(P(4), galvi.gauss(5))
    theory = method().theory(OSCILLATOR)
    assert abs(theory.stage_step - 1 / (inverse * largest)) < 1e-15
    soft = method().theory(OSCILLATOR, lipschitz=1e-6)
    assert soft.stage_step == 1.0 and soft.lipschitz == 1e-6


def test_the_constant_of_keplers_force_is_that_at_pericentre():
    theory = method().theory(KEPLER, step=0.2)
    assert abs(theory.lipschitz - 2 / 0.4**3) < 1e-12
    assert theory.source == "at the start"
    from_apocentre = replace(KEPLER, q0=[-1.6, 0.0], v0=[0.0, -0.5])
    assert abs(method().theory(from_apocentre).lipschitz - 2 / 1.6**3) < 1e-12
    by_user = method().theory(KEPLER, 0.2, lipschitz=31.25)
    assert by_user.source == "given" and abs(by_user.unique_step - theory.unique_step) < 1e-12


def test_a_mass_matrix_and_a_change_of_coordinates_change_no_bound():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    mass, stiff = turn @ np.diag([1.0, 100.0]) @ turn.T, turn @ np.diag([4.0, 100.0]) @ turn.T
    chain = galvi.Canonical(mass, lambda q: 0.5 * q @ stiff @ q, lambda q: stiff @ q)
    theory = method().theory(galvi.Problem(chain, [1.0, 0.5], [0.0, 0.0]), step=0.1)
    assert abs(theory.lipschitz - 100.0) < 1e-4
    assert abs(theory.fixed_point_step * 2.0 * np.sqrt(radius(method())) - 1.0) < 1e-6
    by_user = method().theory(galvi.Problem(chain, [1.0, 0.5], [0.0, 0.0]), lipschitz=100.0)
    # the least mass is 1: safe, and not sharp
    assert abs(by_user.fixed_point_step * 10.0 * np.sqrt(radius(method())) - 1.0) < 1e-12


def test_heavy_and_light_bodies_are_compared_by_their_accelerations():
    """Mercury's pull of the Sun decides, whatever the masses are counted in."""
    problem = galvi.problems.solar_system()
    eight = method(8, galvi.gauss(8))
    theory = eight.theory(problem, 10.0)
    mercury = np.linalg.norm(problem.q0[1] - problem.q0[0])  # au; the Jacobian is 2 G M / r^3
    frequency = 1.0 / (theory.fixed_point_step * np.sqrt(radius(eight)))
    assert abs(frequency**2 / (2 * 2.9591e-4 / mercury**3) - 1) < 1e-4
    assert theory.exists is False and theory.converges is None


def test_no_step_is_called_safe_where_the_force_is_steeper_elsewhere():
    """Kepler's orbit from its apocentre, whose constant at the pericentre allows h < 0.089."""
    problem = galvi.problems.kepler(0.6).with_initial_state([-1.6, 0.0], [0.0, -0.5])
    theory = method(8, galvi.gauss(8)).theory(problem, step=0.6)
    assert theory.unique_step > 0.6 and theory.exists is None
    assert "not said at 0.6" in str(theory) and "yes" not in str(theory).replace("for a yes", "")
    assert theory.to_dict()["exists"] is None and theory.to_dict()["name"] == theory.name


def test_a_constant_of_zero_and_the_smallest_one_allow_any_step():
    falling = galvi.Problem(
        galvi.Canonical(1.0, galvi.UniformField([0.0, -9.8])), [0.0, 0.0], [1.0, 1.0]
    )
    for lipschitz in (0.0, 5e-324):
        theory = method().theory(falling, step=0.1, lipschitz=lipschitz)
        assert theory.exists and theory.converges


def canonical(*functions, q0=0.0, **fields):
    """One coordinate, in motion."""
    return galvi.Problem(galvi.Canonical(1.0, *functions, **fields), [q0], [1.0])


QUARTIC = canonical(lambda q: 0.25 * q[0] ** 4, lambda q: q**3, lambda q: 3.0 * q[None] ** 2)
BROKEN = canonical(lambda q: 0.0 * q @ q, np.zeros_like, lambda q: np.nan * np.eye(1), check=False)
DRAGGED = canonical(lambda q: 0.5 * q @ q, lambda q: q, q0=1.0, force=lambda q, v: -0.1 * v)
FORCES = galvi.NBody([1.0, 1e-3], forces=(galvi.Drag([0.1, 0.1]),))
PULLED = galvi.Problem(FORCES, [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]])
LIGHT = galvi.Problem(galvi.NBody([1.0, 0.0]), [[0.0, 0.0], [1.0, 0.0]], np.zeros((2, 2)))
BODY = galvi.problems.free_rigid_body()


@pytest.mark.parametrize(
    ("problem", "lipschitz", "reason"),
    [
        (BODY, None, "not for a RigidBody"),
        (DRAGGED, 1.0, "here is one besides"),
        (PULLED, None, "here is one besides"),
        (LIGHT, None, "without mass"),
        (LIGHT, 1.0, "without mass"),
        (BROKEN, None, "not finite at the start"),
        (QUARTIC, None, "Give lipschitz"),  # whose force does not change at the start
    ],
)
def test_bounds_that_do_not_apply_are_none_with_the_reason(problem, lipschitz, reason):
    theory = method().theory(problem, 0.1, lipschitz)
    assert reason in theory.no_bounds and theory.order == 8
    assert theory.symmetric is (None if problem is BODY else True)
    for name in ("unique_step", "exists", "fixed_point_step", "converges"):
        assert getattr(theory, name) is None
    assert theory.lipschitz is None or lipschitz


def test_bounds_without_a_step_and_of_an_ill_posed_pair_say_nothing_of_a_step():
    short = method().theory(OSCILLATOR)
    assert short.exists is None and short.unique_step is not None
    assert method().theory(QUARTIC, lipschitz=4.25).exists is None
    ill_posed = galvi.theory(P(8), galvi.gauss(1), KEPLER, 0.1)
    assert ill_posed.unique_step is None and "no bound" in str(ill_posed)
