"""External forces: against SciPy, in every form a user may give them, and bad ones."""

import functools

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
MASS = np.array([[1.0, 0.3], [0.3, 2.0]])
SPRING = galvi.LinearSpring(1.5)
START = np.array([1.0, 0.5]), np.array([0.1, 0.4])
WIND = np.array([0.4, -0.2])


def drag(q, v):
    """Quadratic, in still air."""
    return -0.2 * np.sqrt(np.sum(v * v)) * v


def windy(q, v, t):
    """Quadratic, in a wind that turns."""
    relative = v - WIND * np.cos(t)
    return -0.2 * np.sqrt(np.sum(relative * relative)) * relative


def spring_gradient(q):
    return 1.5 * q


def moving_gradient(q, t):
    return (1.5 + 0.5 * np.sin(t)) * q


def moving_potential(q, t):
    return 0.5 * (1.5 + 0.5 * np.sin(t)) * (q @ q)


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


def lagrangian(q, v):
    return 0.5 * v @ MASS @ v - 0.75 * q @ q


def lagrangian_slopes(q, v):
    return np.concatenate((MASS @ v, -1.5 * q))


compiled = functools.cache(numba.njit)
SYSTEMS = {
    "a potential known to galvi": (galvi.Canonical(MASS, SPRING, force=compiled(drag)), 0, 0),
    "a compiled gradient": (
        galvi.Canonical(
            MASS, lambda q: 0.75 * q @ q, compiled(spring_gradient), force=compiled(windy),
            timed_force=True,
        ), 0, 1,
    ),
    "a timed potential": (
        galvi.Canonical(
            MASS, moving_potential, compiled(moving_gradient), force=compiled(drag),
            explicit_time=True,
        ), 1, 0,
    ),
    "functions of Python": (
        galvi.Canonical(
            MASS, moving_potential, moving_gradient, force=windy, explicit_time=True,
            timed_force=True,
        ), 1, 1,
    ),
    "a compiled force and a potential of Python": (
        galvi.Canonical(MASS, lambda q: 0.75 * q @ q, force=compiled(drag)), 0, 0,
    ),
    "a Lagrangian": (
        galvi.Lagrangian(
            lagrangian, galvi.Rn(2), compiled(lagrangian_slopes), compiled(windy), timed_force=True
        ), 0, 1,
    ),
}  # fmt: skip


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


def no_gradient(q):
    return 0.0 * q


def pull(q, v):
    return -1.5 * q


def falling(c, mass=1.0):
    """Quadratic drag and gravity, in the units of any mass."""
    return galvi.Canonical(
        mass, lambda q: 0.0, compiled(no_gradient),
        force=lambda q, v: mass * (-9.81 - c * np.abs(v) * v),
    )  # fmt: skip


@pytest.mark.parametrize("place", [0.0, 1e3])
@pytest.mark.parametrize("v", [0.0, 1e-12])
@pytest.mark.parametrize(("c", "mass", "off"), [(1.0, 1e-20, 1e-9), (1e3, 1.0, 1e-3), (1e6, 1, 1)])
def test_a_fall_from_rest_is_solved_however_stiff_the_drag(c, mass, off, place, v):
    """v = -u tanh(9.81 t / u) with u^2 = 9.81 / c; q is the integral."""
    problem = galvi.Problem(falling(c, mass), [place], [v])
    run = galvi.integrate(problem, FOUR, 0.1, 10)
    assert run.success, run.status
    u = np.sqrt(9.81 / c)
    fallen = np.logaddexp(9.81 / u, -9.81 / u) / c - np.log(2.0) / c
    assert abs(place - run.q[-1, 0] - fallen) < off * fallen  # 6e-11, 4e-4, 1e-4 of it
    assert run.counts["iterations"] < 150  # 106


@pytest.mark.parametrize("size", [1.0, 1e-25])
def test_a_lagrangian_at_rest_in_the_origin_is_driven_to_round_off(size):
    """q'' = -q + size cos 2 t from rest in 0: q = size (cos t - cos 2 t) / 3."""
    system = galvi.Lagrangian(
        lambda q, v, t: 0.5 * v @ v - 0.5 * q @ q + size * np.cos(2 * t) * q[0], galvi.Rn(1),
        lambda q, v, t: np.array([v[0], size * np.cos(2 * t) - q[0]]), explicit_time=True,
    )  # fmt: skip
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), method, 1.0, 3)
    exact = size * (np.cos(run.t) - np.cos(2 * run.t)) / 3
    assert np.max(np.abs(run.q[:, 0] - exact)) < 1e-9 * size  # 3e-10


@pytest.mark.parametrize(
    ("degree", "rule"),
    [(1, galvi.radau(1, left=True)), (1, galvi.radau(1)), (2, galvi.lobatto(2))],
)
def test_equations_hold_also_for_functions_that_vanish_at_every_stage(degree, rule):
    """p1 = p0 + h sum b f and the stages' slopes, from the curve: only rates see such functions."""
    system = galvi.Canonical(1.0, lambda q: 0.0, compiled(no_gradient), force=compiled(rough))
    method = galvi.Galerkin(galvi.Polynomials(degree), rule)
    run = galvi.integrate(galvi.Problem(system, [0.0], [1.0]), method, 0.5, 4)
    table, rates = method.table, run.curves.coefficients[:, 0] @ method.table.slope.T / 0.5
    f = rough(0.0, rates)
    assert np.allclose(run.p[1:, 0], run.p[:-1, 0] + 0.5 * f @ table.b, rtol=0, atol=1e-14)
    left = (table.b * rates) @ table.slope + 0.5 * (table.b * f) @ table.psi
    assert np.allclose(
        left, run.p[1:] * table.end, rtol=0, atol=1e-14
    )  # 2e-16; 0.1 where only places are looked at


def rough(q, v):
    return -2.0 * np.abs(v) * v


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
    starts = [problem.starting_at(problem.q0 * (1 + k / 10), problem.v0) for k in range(3)]
    for run, start in zip(galvi.integrate_many(starts, FOUR, 0.25, 8), starts, strict=True):
        assert np.array_equal(run.q, galvi.integrate(start, FOUR, 0.25, 8).q)


@pytest.mark.parametrize(
    ("force", "timed", "error", "words"),
    [
        (3.0, False, TypeError, "force must be a function of (q, v); received 3.0"),
        ("x", True, TypeError, "force must be a function of (q, v, t)"),
        (None, True, ValueError, "timed_force means a force(q, v, t); received no force"),
    ],
)
@pytest.mark.parametrize("kind", ["canonical", "lagrangian", "body"])
def test_what_is_no_force_is_refused_when_the_system_is_made(kind, force, timed, error, words):
    make = {
        "canonical": lambda **more: galvi.Canonical(1.0, SPRING, **more),
        "lagrangian": lambda **more: galvi.Lagrangian(lagrangian, galvi.Rn(2), **more),
        "body": lambda **more: galvi.RigidBody((1, 2, 2), **more),
    }[kind]
    with pytest.raises(error, match=words.replace("(", r"\(").replace(")", r"\)")):
        make(force=force, timed_force=timed)


@pytest.mark.parametrize(
    ("force", "words"),
    [
        (lambda q, v: np.zeros(3), r"force must return an array of shape \(2,\); received"),
        (lambda q, v: v * np.nan, "force must be finite at the start"),
        (lambda q, v: v * 1j, "of real numbers"),
    ],
)  # fmt: skip
def test_a_force_that_returns_what_it_should_not_is_refused_before_the_run(force, words):
    with pytest.raises(ValueError, match=words):
        galvi.integrate(
            galvi.Problem(galvi.Canonical(1.0, SPRING, force=force), *START), FOUR, 0.1, 1
        )


def test_a_force_that_fails_on_the_way_leaves_nan_and_says_so():
    system = galvi.Canonical(1.0, SPRING, force=compiled(failing), timed_force=True)
    run = galvi.integrate(galvi.Problem(system, *START), FOUR, 0.25, 8)
    assert not run.success
    assert run.failed_step == 5
    assert np.all(np.isnan(run.q[5:])) and np.all(np.isfinite(run.q[:5]))
    assert "infinite or NaN" in run.status


def failing(q, v, t):
    return v * (np.nan if t > 1.0 else 0.0)


def test_what_a_force_raises_reaches_the_caller():
    def broken(q, v):
        if q[0] < 0.9:
            raise ArithmeticError("no wind here")
        return 0.0 * v

    with pytest.raises(ArithmeticError, match="no wind here"):
        galvi.integrate(
            galvi.Problem(galvi.Canonical(1.0, SPRING, force=broken), *START), FOUR, 0.1, 9
        )


def test_fixed_point_iteration_is_refused_for_a_force():
    problem = galvi.Problem(SYSTEMS["a compiled gradient"][0], *START)
    with pytest.raises(ValueError, match="external force"):
        galvi.integrate(problem, FOUR, 0.1, 1, solver="fixed_point")


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda: galvi.integrate(galvi.problems.free_body_se3(), FOUR, 0.1, 1), "one body"),
        (
            lambda: galvi.integrate(galvi.problems.kepler(0.1), FOUR, 0.1, 4, save_every=2),
            "needs the Galerkin curves",
        ),
        (
            lambda: galvi.integrate(
                galvi.problems.kepler(0.1), FOUR, 0.1, 4, save_every=2, curves=True
            ),
            "every step",
        ),
    ],
)
def test_a_balance_says_what_it_needs(run, words):
    with pytest.raises(ValueError, match=words):
        galvi.momentum_balance(run())
