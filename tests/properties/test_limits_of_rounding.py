"""Steps near the end of a chart, motions near the smallest float64, and rounding of tables."""

import numpy as np
import pytest
from numba import njit

import galvi

STEP = 0.6


def hall_method(chart):
    """H's method of figure 3.8."""
    return galvi.Galerkin(galvi.Polynomials(19), galvi.gauss(20), chart=chart)


@pytest.mark.parametrize("weight", [28.0, 29.0])
def test_steps_near_the_end_of_a_chart_are_solved(weight):
    """They turn by 2.96 and 3.05; Cayley's chart ends at pi. Some starts 1e-13 apart failed."""
    problem = galvi.problems.pendulum_3d(weight=weight, inverted=True)
    upright_run = galvi.integrate(problem, hall_method(galvi.Exponential()), STEP, 9)
    rng = np.random.default_rng(0)
    for _ in range(3):
        v = problem.system.velocity(upright_run.p[-1]) + 1e-13 * rng.normal(size=3)
        start = galvi.Problem(problem.system, upright_run.q[-1], v)
        in_cayley, in_exponential = (
            galvi.integrate(start, hall_method(chart), STEP, 1)
            for chart in (galvi.Cayley(), galvi.Exponential())
        )
        assert in_cayley.success, in_cayley.status
        angle = np.arccos((np.trace(in_cayley.q[0].T @ in_cayley.q[1]) - 1.0) / 2.0)
        assert 2.9 < angle < np.pi
        assert (
            np.max(np.abs(in_cayley.q - in_exponential.q)) < 4e-3
        )  # 9e-5 and 1.1e-3, errors of the two methods


def test_the_status_of_a_step_that_turns_less_than_its_chart_allows_blames_the_solver():
    problem = galvi.problems.pendulum_3d(weight=27.0, inverted=True)
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(4))
    statuses = [
        galvi.integrate(problem, method, step, 40).status for step in np.arange(0.7, 1.0, 0.02)
    ]
    chart_statuses = [status for status in statuses if "the chart Cayley ends at" in status]
    assert any("Newton's" in status for status in chart_statuses)
    for status in chart_statuses:
        angle = float(status.split("turns by ")[1].split()[0])
        assert ("Newton's method did not solve" in status) == (angle < 3.141)


@njit
def potential(q):
    """-cos q."""
    return -np.cos(q[0])


@njit
def gradient(q):
    """sin q."""
    return np.sin(q)


@njit
def drag(q, v):
    """-v / 10."""
    return -0.1 * v


@pytest.mark.parametrize(("start", "points"), [(1e-300, 5), (1e-307, 3)])
def test_a_motion_that_decays_below_the_smallest_normal_number_goes_on(points, start):
    """It decays by e^(-25), to subnormal numbers of few bits, where steps once failed."""
    system = galvi.Canonical(1.0, potential, gradient, force=drag)
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(points))
    run = galvi.integrate(galvi.Problem(system, [start], [0.0]), method, 1.0, 500)
    assert run.outcome.end is galvi.End.COMPLETED
    large = galvi.integrate(galvi.Problem(system, [1e-8], [0.0]), method, 1.0, 500)
    expected = large.q[:, 0] * (start / 1e-8)
    resolved = np.abs(expected) > 1e-310
    assert np.allclose(run.q[resolved, 0], expected[resolved], rtol=1e-6, atol=0.0)
    assert np.max(np.abs(run.q[400:])) <= max(2.0 * np.max(np.abs(expected[400:])), 1e-321)


def test_angular_momentum_does_not_grow_by_the_rounding_of_the_table():
    """H's orbit of figure 2.13: by 3.8e-17 a step with tables of float64, 0.3e-17 with low parts;
    a random walk of that length shows 0.3e-17."""
    method = galvi.Galerkin(galvi.Polynomials(7), galvi.gauss(16))
    run = galvi.integrate(galvi.problems.kepler(0.6), method, 2.0, 20_000, curves=False)
    q, p = (x.astype(np.longdouble) for x in (run.q, run.p))
    relative_errors = ((q[:, 0] * p[:, 1] - q[:, 1] * p[:, 0]) / 0.8 - 1).astype(np.float64)
    assert abs(np.polyfit(np.arange(len(relative_errors)), relative_errors, 1)[0]) < 1.8e-17
