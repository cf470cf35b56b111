"""What the status of a completed run on a Lagrangian says of its energy."""

import math

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.run.energies import kick_energy, noise

PENDULUM = galvi.PlanarChain([1.0], [1.0], 1.0)


def falling(q, v):
    """-sqrt(f - v^2 / f), f = 1 - 2 / q: undefined beyond the speed of light."""
    f = 1.0 - 2.0 / q[0]
    return -math.sqrt(f - v[0] ** 2 / f)


@njit
def falling_slopes(q, v):
    """Its derivatives by v and q."""
    f, slope = 1.0 - 2.0 / q[0], 2.0 / q[0] ** 2
    r = np.sqrt(f - v[0] ** 2 / f)
    return np.array([v[0] / f / r, -0.5 * (slope + v[0] ** 2 / f**2 * slope) / r])


def gauss(points):
    """Collocation."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points))


@pytest.mark.parametrize("share", [0.9, 0.99, 0.999])
@pytest.mark.parametrize("step", [0.02, 0.1, 0.2])
def test_a_lagrangian_that_is_not_defined_for_a_near_velocity_does_not_end_a_run(share, step):
    system = galvi.Lagrangian(falling, galvi.Rn(1), falling_slopes)
    problem = galvi.Problem(system, [6.0], [-share * (1.0 - 2.0 / 6.0)])
    run = galvi.integrate(problem, gauss(2), step, round(4.0 / step))
    assert run.success and run.status.startswith("Completed.")


def lifted(angle):
    """A heavy body turned about x from where its centre of mass is below."""
    c, s = math.cos(angle), math.sin(angle)
    R = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return galvi.Problem(galvi.problems.pendulum_3d(2.0).system, R, np.zeros(3))


SPRING = galvi.Canonical(3.0, lambda q: 0.5 * q[0] ** 2, lambda q: q)
OF_LAGRANGE = galvi.Lagrangian(lambda q, v: 1.5 * v[0] ** 2 - 0.5 * q[0] ** 2, galvi.Rn(1))
ABOUT_X = lifted(0.0).system.inertia[0, 0]
AT_REST = {  # problem -> F . M^-1 F
    "canonical": (galvi.Problem(SPRING, [2.0], [0.0]), 4.0 / 3.0),
    "Lagrangian": (galvi.Problem(OF_LAGRANGE, [2.0], [0.0]), 4.0 / 3.0),
    "rigid body": (lifted(0.3), (2.0 * math.sin(0.3)) ** 2 / ABOUT_X),
    "free body": (galvi.problems.free_body_se3(g=(0.0, 0.0, -9.81)), 9.81**2),
}


@pytest.mark.parametrize("name", AT_REST)
def test_the_energy_that_a_force_gives_in_a_step_is_that_of_uniform_acceleration(name):
    """The springs' is less by the change of their force on the way."""
    problem, power = AT_REST[name]
    mass = getattr(problem.system, "mass", 1.0) if name == "free body" else 1.0
    for step in (0.1, -0.1, 0.2):
        way = 0.5 * step**2 * 2.0 / 3.0 if name in ("canonical", "Lagrangian") else 0.0
        expected = 0.5 * step**2 * power * mass - 0.5 * way**2
        assert kick_energy(problem, step) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["canonical", "Lagrangian"])
def test_a_force_that_reverses_gives_no_more_than_the_potential_falls(name):
    """From rest at x = 2 with k = 1. V is looked at from 0.71 to 1.41 of the way to its minimum."""
    problem, _ = AT_REST[name]
    given = [kick_energy(problem, step) for step in (2.5, 50.0, 3e4, -1e9)]
    assert all(0.91 * 2.0 <= energy <= 2.0 for energy in given)
    gravity = galvi.Problem(
        galvi.Canonical(2.0, lambda q: 3.0 * q[0], lambda q: [3.0]), [1.0], [0.0]
    )
    assert kick_energy(gravity, 1e4) == pytest.approx(0.5 * 1e8 * 9.0 / 2.0, rel=1e-9)


def test_a_start_at_rest_excuses_no_error_in_steps_of_many_periods():
    """The elastic pendulum in steps of 35 periods, whose energy goes from 0.9 to 123: wherever
    Newton's method ends, or if it does not."""
    run = galvi.integrate(galvi.problems.elastic_pendulum(), gauss(5), 218, 5, solver="newton")
    assert not run.success


def test_the_round_off_of_an_energy_is_taken_larger_where_a_body_is_at_rest():
    """By the square root of the rounding unit, where a motion grows from round-off."""
    unit, potential = np.finfo(float).eps, 2.0
    for speed, nudge in ((0.0, math.sqrt(unit)), (1.0, 64.0 * unit)):
        assert noise(galvi.Problem(SPRING, [2.0], [speed])) == pytest.approx(
            2.0 * nudge * potential, rel=0.01
        )


@pytest.mark.slow(beside="test_a_start_at_rest_excuses_no_error_in_steps_of_many_periods")
def test_a_changed_energy_is_told_however_large_the_step():
    """Against bounds of the measure: T at the start, and that or the range of V over the run."""
    rng = np.random.default_rng(0)
    told, ruined = 0, 0
    for _ in range(200):
        start = rng.normal(scale=1.5, size=2)
        problem = galvi.Problem(galvi.Lagrangian(PENDULUM, galvi.Rn(1)), start[:1], start[1:])
        run = galvi.integrate(problem, gauss(2), rng.uniform(0.3, 6.0), int(rng.integers(1, 5)))
        if not np.all(np.isfinite(run.q[-1])):
            continue
        kinetic, potential = 0.5 * run.p[:, 0] ** 2, -np.cos(run.q[:, 0])
        off = np.max(np.abs(kinetic + potential - kinetic[0] - potential[0]))
        least, most = kinetic[0], max(kinetic[0], np.ptp(potential))
        if off > 0.011 * most:
            told += 1
            assert "the energy changed" in run.status
        elif off < 0.009 * least:
            assert run.status.startswith("Completed.")
        if off > 1.01 * most:
            ruined += 1
            assert not run.success and run.status.startswith("Ruined from step ")
        elif off < 0.99 * least:
            assert run.success
    assert told > 20 and ruined > 5
