"""A user's forces, in every form, against SciPy and closed forms, also where they are stiff."""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi
from tests.properties.forced_systems import (
    FOUR,
    MASS,
    SPRING,
    START,
    SYSTEMS,
    compiled,
    drag,
    spring_gradient,
    timed_gradient,
    windy_drag,
    zero_gradient,
)


@functools.cache
def truth(timed_potential, timed_force, duration=4.0):
    def right_side(t, y):
        q, v = y[:2], y[2:]
        pull = timed_gradient(q, t) if timed_potential else spring_gradient(q)
        push = windy_drag(q, v, t) if timed_force else drag(q, v)
        return np.concatenate([v, np.linalg.solve(MASS, push - pull)])

    solution = solve_ivp(
        right_side, (0, duration), np.concatenate(START), method="DOP853", rtol=1e-13, atol=1e-14
    )
    return solution.y[:2, -1]


@pytest.mark.parametrize(
    "name",
    ["a timed potential", "functions of Python", "a compiled force and a potential of Python"],
)
def test_a_run_with_a_force_has_order_4_however_its_functions_are_given(name):
    system, timed_potential, timed_force = SYSTEMS[name]
    problem = galvi.Problem(system, *START)
    end = truth(timed_potential, timed_force)
    steps = (9, 13, 20)
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    runs = [galvi.integrate(problem, method, 4.0 / n, n) for n in steps]
    assert all(run.success for run in runs)
    errors = [np.max(np.abs(run.q[-1] - end)) for run in runs]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 3.8 < order < 4.3  # 3.98 to 4.1


def test_a_wrong_sign_of_the_force_is_seen():
    problem = galvi.Problem(galvi.Canonical(MASS, SPRING, force=lambda q, v: -drag(q, v)), *START)
    run = galvi.integrate(problem, FOUR, 0.4, 10)
    assert np.max(np.abs(run.q[-1] - truth(0, 0))) > 0.1


def brake(R, v):
    return -0.2 * v


def test_a_torque_slows_a_body_as_scipy_says():
    inertia = np.array([1.0, 1.5, 2.0])
    body = galvi.RigidBody(inertia, force=compiled(brake))
    problem = galvi.Problem(body, np.eye(3), [0.7, -0.4, 1.1])

    def right_side(t, y):
        R, v = y[:9].reshape(3, 3), y[9:]
        hat = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        angular_acceleration = (np.cross(inertia * v, v) + brake(R, v)) / inertia
        return np.concatenate([(R @ hat).ravel(), angular_acceleration])

    y0 = np.concatenate([np.eye(3).ravel(), problem.v0])
    end = solve_ivp(right_side, (0, 4), y0, method="DOP853", rtol=1e-12, atol=1e-13).y[:9, -1]
    errors = []
    for steps in (10, 20):
        run = galvi.integrate(problem, FOUR, 4.0 / steps, steps)
        errors.append(np.max(np.abs(run.q[-1].ravel() - end)))
    assert errors[1] < 1e-9  # 4e-11
    assert 7.0 < np.log2(errors[0] / errors[1]) < 9.0
    balance = galvi.momentum_balance(run)
    assert np.max(np.abs(balance.defect)) < 1e-13  # 1e-15
    assert np.max(np.abs(balance.force)) > 0.1


@pytest.mark.parametrize(("rule", "linear"), [(galvi.gauss(4), True), (galvi.lobatto(5), False)])
def test_momentum_changes_by_the_impulses_and_by_nothing_else(rule, linear):
    system = galvi.Canonical(2.0, SPRING, force=compiled(windy_drag), timed_force=True)
    run = galvi.integrate(
        galvi.Problem(system, *START), galvi.Galerkin(galvi.Polynomials(4), rule), 0.3, 30
    )
    balance = galvi.momentum_balance(run, linear=linear)
    assert balance.defect.shape == balance.momentum.shape == balance.force.shape
    assert np.max(np.abs(balance.defect)) < 1e-13  # 2e-15
    assert np.max(np.abs(balance.force)) > 0.1
    wrong = galvi.momentum_balance(
        galvi.Trajectory(
            galvi.Problem(galvi.Canonical(2.0, SPRING, force=drag), *START),
            run.t,
            run.q,
            run.p,
            step=run.step,
            method=run.method,
            curves=run.curves,
        ),
        linear=linear,
    )
    assert np.max(np.abs(wrong.defect)) > 1e-2


def test_a_force_that_fails_on_the_way_leaves_nan_and_says_so():
    system = galvi.Canonical(
        1.0,
        SPRING,
        force=compiled(lambda q, v, t: v * (np.nan if t > 1.0 else 0.0)),
        timed_force=True,
    )
    run = galvi.integrate(galvi.Problem(system, *START), FOUR, 0.25, 8)
    assert not run.success
    assert run.failed_step == 5
    assert np.all(np.isnan(run.q[5:])) and np.all(np.isfinite(run.q[:5]))
    assert "infinite or NaN" in run.status


def falling_body(c, mass=1.0):
    """A body of any mass with gravity and a drag of c v^2 per mass."""
    return galvi.Canonical(
        mass,
        lambda q: 0.0,
        compiled(zero_gradient),
        force=lambda q, v: mass * (-9.81 - c * np.abs(v) * v),
    )


@pytest.mark.parametrize(("height", "v"), [(0.0, 0.0), (1e3, 0.0), (1e3, 1e-12)])
@pytest.mark.parametrize(
    ("c", "mass", "tolerance"), [(1.0, 1e-20, 1e-9), (1e3, 1.0, 1e-3), (1e6, 1, 1)]
)
def test_a_fall_from_rest_is_solved_however_stiff_the_drag(c, mass, tolerance, height, v):
    """v = -u tanh(9.81 t / u) with u^2 = 9.81 / c; q is the integral."""
    problem = galvi.Problem(falling_body(c, mass), [height], [v])
    run = galvi.integrate(problem, FOUR, 0.1, 10)
    assert run.success, run.status
    terminal_speed = np.sqrt(9.81 / c)
    fallen = np.logaddexp(9.81 / terminal_speed, -9.81 / terminal_speed) / c - np.log(2.0) / c
    assert abs(height - run.q[-1, 0] - fallen) < tolerance * fallen  # 6e-11, 4e-4, 1e-4 of it
    assert run.counts["iterations"] < 200  # 152, some of them before Newton's method takes over


@pytest.mark.parametrize("size", [1.0, 1e-25])
def test_a_lagrangian_at_rest_in_the_origin_is_driven_to_round_off(size):
    """q'' = -q + size cos 2 t from rest in 0: q = size (cos t - cos 2 t) / 3."""
    system = galvi.Lagrangian(
        lambda q, v, t: 0.5 * v @ v - 0.5 * q @ q + size * np.cos(2 * t) * q[0],
        galvi.Rn(1),
        lambda q, v, t: np.array([v[0], size * np.cos(2 * t) - q[0]]),
        explicit_time=True,
    )
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), method, 1.0, 3)
    exact = size * (np.cos(run.t) - np.cos(2 * run.t)) / 3
    assert np.max(np.abs(run.q[:, 0] - exact)) < 1e-9 * size  # 3e-10


@pytest.mark.parametrize(
    ("degree", "rule"),
    [(1, galvi.radau(1)), (2, galvi.lobatto(2))],
)
def test_equations_hold_also_for_functions_that_vanish_at_every_stage(degree, rule):
    """p1 = p0 + h sum b f, and the stage equations, from the curve: such functions show in the
    velocities alone."""
    system = galvi.Canonical(
        1.0, lambda q: 0.0, compiled(zero_gradient), force=compiled(quadratic_drag)
    )
    method = galvi.Galerkin(galvi.Polynomials(degree), rule)
    run = galvi.integrate(galvi.Problem(system, [0.0], [1.0]), method, 0.5, 4)
    table, rates = method.table, run.curves.coefficients[:, 0] @ method.table.slope.T / 0.5
    f = quadratic_drag(0.0, rates)
    assert np.allclose(run.p[1:, 0], run.p[:-1, 0] + 0.5 * f @ table.b, rtol=0, atol=1e-14)
    momentum_terms = (table.b * rates) @ table.slope + 0.5 * (table.b * f) @ table.psi
    assert np.allclose(
        momentum_terms, run.p[1:] * table.end, rtol=0, atol=1e-14
    )  # 2e-16; 0.1 for equations of positions alone


def quadratic_drag(q, v):
    return -2.0 * np.abs(v) * v
