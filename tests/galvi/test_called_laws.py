"""Compiled functions that branch, called from the iteration in lanes: as in the general kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.fast.lanes import called
from tests.galvi.group_bodies import MOMENTS, R0, SPIN, bent, bent_slope

slope_of_body = njit(bent_slope)


@njit
def branching_slopes(q, v):
    """L = (1 + r^2 / 5) |v|^2 / 2 + |v|^4 / 20 - V, V = |q|^2 / 2, and four times that above 0."""
    out, square, speed = np.empty(4), q[0] ** 2 + q[1] ** 2, v[0] ** 2 + v[1] ** 2
    for i in range(2):
        out[i] = (1.0 + 0.2 * square + 0.2 * speed) * v[i]
        out[2 + i] = 0.2 * speed * q[i] - (4.0 if q[1] > 0.0 else 1.0) * q[i]
    return out


def L(q: Any, v: Any) -> Any:
    square, speed = q @ q, v @ v
    factor = 4.0 if q[1] > 0.0 else 1.0
    return 0.5 * (1.0 + 0.2 * square) * speed + 0.05 * speed**2 - 0.5 * factor * square


@njit
def branching_gradient(R):
    return slope_of_body(R) if R[0, 0] < 9.0 else R


@njit
def braking(q, v):
    return -0.3 * v if v[0] > 0.0 else -0.1 * v


PLANE = galvi.Problem(galvi.Lagrangian(L, galvi.Rn(2), branching_slopes), [0.9, -0.8], [0.3, 0.1])
FORCED = galvi.Problem(
    galvi.Canonical(2.0, galvi.LinearSpring(3.0), force=braking), [1.0, 0.4], [0.2, 0.5]
)
COUPLED = galvi.Problem(
    galvi.Canonical([[2.0, 0.3], [0.3, 1.0]], galvi.LinearSpring(3.0), force=braking),
    [1.0, 0.4], [0.2, 0.5],
)  # fmt: skip
BODY = galvi.Problem(galvi.RigidBody(MOMENTS, bent, branching_gradient), R0, SPIN)
TORQUE = galvi.Problem(galvi.RigidBody(MOMENTS, None, None, braking), R0, SPIN)
PROBLEMS = {
    "plane": PLANE, "forced": FORCED, "coupled": COUPLED, "body": BODY, "torque": TORQUE
}  # fmt: skip


@pytest.mark.slow_cases("forced-10", "coupled-10")
@pytest.mark.parametrize("points", [6, 7, 10])
@pytest.mark.parametrize("name", PROBLEMS)
def test_a_run_is_that_of_the_general_kernel_and_its_status_says_what_was_called(
    name: str, points: int
) -> None:
    problem, method = PROBLEMS[name], galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(points))
    run = galvi.integrate(problem, method, 0.05, 6)
    general = galvi.integrate(problem, method, 0.05, 6, solver="newton")
    assert run.success and run.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    assert "Compiled functions were called one state at a time" in run.status
    assert "branches" in run.status and general.status == "Completed."
    np.testing.assert_allclose(run.q, general.q, rtol=0.0, atol=1e-14)  # 1e-15
    np.testing.assert_allclose(run.p, general.p, rtol=0.0, atol=2e-14)


@njit
def fenced(q, v):
    if q[0] > 1.0:
        raise ValueError("beyond the fence")
    return np.array([v[0], 0.0])


@pytest.mark.parametrize("solver", ["auto", "fixed_point"])
def test_what_a_function_raises_reaches_the_caller(solver: str) -> None:
    free = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, galvi.Rn(1), fenced)
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    with pytest.raises(ValueError, match="beyond the fence"):
        galvi.integrate(galvi.Problem(free, [0.0], [1.0]), method, 0.1, 20, solver=solver)
    short = galvi.integrate(galvi.Problem(free, [0.0], [1.0]), method, 0.1, 9, solver=solver)
    assert short.success and abs(short.q[-1, 0] - 0.9) < 1e-14


@njit
def walled(q, v):
    if q[0] > 1.2:
        raise ValueError("inside the wall")
    return np.array([v[0], -400.0 * q[0]])


def test_an_exception_where_only_the_iteration_strays_leaves_the_step_to_newtons_method() -> None:
    spring = galvi.Lagrangian(lambda q, v: 0.5 * v @ v - 200.0 * q @ q, galvi.Rn(1), walled)
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(galvi.Problem(spring, [1.0], [0.0]), method, 0.2, 1)
    assert run.success and run.counts["newton_steps"] == 1
    assert abs(run.q[-1, 0] - np.cos(4.0)) < 1e-6


def test_a_planted_fault_in_what_is_called_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    numbers = called.called_numbers

    def without_force(kernel: Any, layout: Any) -> Any:
        found = numbers(kernel, layout)
        found[called.FORCE_KIND] = 0.0
        return found

    monkeypatch.setattr("galvi.fast.law_stepper.called_numbers", without_force)
    problem = galvi.Problem(
        galvi.Canonical(2.0, galvi.LinearSpring(3.0), force=braking), [1.0, 0.4], [0.2, 0.5]
    )
    run = galvi.integrate(problem, method, 0.05, 4)
    sound = galvi.integrate(problem, method, 0.05, 4, solver="newton")
    assert np.abs(run.q - sound.q).max() > 1e-5
