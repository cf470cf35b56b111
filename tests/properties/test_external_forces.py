"""External forces in every form a user may give them: against SciPy, and to the bit."""

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
    moving_gradient,
    no_gradient,
    spring_gradient,
    windy,
)


@functools.cache
def truth(timed_potential, timed_force, duration=4.0):
    def slope(t, y):
        q, v = y[:2], y[2:]
        pull = moving_gradient(q, t) if timed_potential else spring_gradient(q)
        push = windy(q, v, t) if timed_force else drag(q, v)
        return np.concatenate([v, np.linalg.solve(MASS, push - pull)])

    found = solve_ivp(
        slope, (0, duration), np.concatenate(START), method="DOP853", rtol=1e-13, atol=1e-14
    )
    return found.y[:2, -1]


@pytest.mark.slow_cases("a potential known to galvi", "a compiled gradient", "a Lagrangian")
@pytest.mark.parametrize("kind", SYSTEMS)
def test_a_run_with_a_force_has_order_4_however_its_functions_are_given(kind):
    system, timed_potential, timed_force = SYSTEMS[kind]
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


def test_a_force_of_the_place_alone_equals_a_potential():
    pulled = galvi.Canonical(MASS, lambda q: 0.0, compiled(no_gradient), force=compiled(pull))
    forced = galvi.integrate(galvi.Problem(pulled, *START), FOUR, 0.3, 40)
    known = galvi.integrate(galvi.Problem(galvi.Canonical(MASS, SPRING), *START), FOUR, 0.3, 40)
    assert np.max(np.abs(forced.q - known.q)) < 5e-14  # 4e-15
    assert np.max(np.abs(forced(3.3) - known(3.3))) < 5e-14
    assert np.max(np.abs(forced.p - known.p)) < 5e-14


def pull(q, v):
    return -1.5 * q


def test_a_torque_slows_a_body_as_scipy_says():
    inertia = np.array([1.0, 1.5, 2.0])
    body = galvi.RigidBody(inertia, force=compiled(brake))
    problem = galvi.Problem(body, np.eye(3), [0.7, -0.4, 1.1])

    def slope(t, y):
        R, v = y[:9].reshape(3, 3), y[9:]
        hat = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        turn = (np.cross(inertia * v, v) + brake(R, v)) / inertia
        return np.concatenate([(R @ hat).ravel(), turn])

    y0 = np.concatenate([np.eye(3).ravel(), problem.v0])
    end = solve_ivp(slope, (0, 4), y0, method="DOP853", rtol=1e-12, atol=1e-13).y[:9, -1]
    errors = []
    for steps in (10, 20):
        run = galvi.integrate(problem, FOUR, 4.0 / steps, steps)
        errors.append(np.max(np.abs(run.q[-1].ravel() - end)))
    assert errors[1] < 1e-9  # 4e-11
    assert 7.0 < np.log2(errors[0] / errors[1]) < 9.0
    balance = galvi.momentum_balance(run)
    assert np.max(np.abs(balance.defect)) < 1e-13  # 1e-15
    assert np.max(np.abs(balance.force)) > 0.1


def brake(R, v):
    return -0.2 * v


@pytest.mark.slow_cases("Gauss 4-False")
@pytest.mark.parametrize("linear", [False, True])
@pytest.mark.parametrize("rule", [galvi.gauss(4), galvi.lobatto(5)], ids=lambda rule: rule.name)
def test_momentum_changes_by_the_impulses_and_by_nothing_else(rule, linear):
    system = galvi.Canonical(2.0, SPRING, force=compiled(windy), timed_force=True)
    run = galvi.integrate(
        galvi.Problem(system, *START), galvi.Galerkin(galvi.Polynomials(4), rule), 0.3, 30
    )
    balance = galvi.momentum_balance(run, linear=linear)
    assert balance.defect.shape == balance.momentum.shape == balance.force.shape
    assert np.max(np.abs(balance.defect)) < 1e-13  # 2e-15
    assert np.max(np.abs(balance.force)) > 0.1
    wrong = galvi.momentum_balance(
        galvi.Trajectory(
            galvi.Problem(galvi.Canonical(2.0, SPRING, force=drag), *START), run.t, run.q, run.p,
            step=run.step, method=run.method, curves=run.curves,
        ),
        linear=linear,
    )  # fmt: skip
    assert np.max(np.abs(wrong.defect)) > 1e-2


def test_a_forced_run_is_continued_saved_and_loaded_to_the_bit(tmp_path):
    problem = galvi.Problem(SYSTEMS["a compiled gradient"][0], *START)
    whole = galvi.integrate(problem, FOUR, 0.25, 20)
    part = galvi.integrate(problem, FOUR, 0.25, 12)
    galvi.save(part, tmp_path / "run.npz")
    rest = galvi.resume(galvi.load(tmp_path / "run.npz", problem), 8)
    assert np.array_equal(rest.q, whole.q[12:])
    assert np.array_equal(rest.p, whole.p[12:])
    assert np.array_equal(part(1.1), whole(1.1))


def test_many_forced_runs_equal_single_ones():
    problem = galvi.Problem(SYSTEMS["a compiled gradient"][0], *START)
    starts = [problem.with_initial_state(problem.q0 * (1 + k / 10), problem.v0) for k in range(3)]
    for run, start in zip(galvi.integrate_many(starts, FOUR, 0.25, 8), starts, strict=True):
        assert np.array_equal(run.q, galvi.integrate(start, FOUR, 0.25, 8).q)


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
