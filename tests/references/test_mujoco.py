"""MuJoCo against equations of motion written here: its orders, its runs and its frames."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi

pytest.importorskip("mujoco")

import mujoco

from references.mujoco import body as mujoco_body
from references.mujoco import body as mujoco_states
from references.mujoco import engine as mujoco_engine
from references.mujoco import steps as mujoco_steps
from references.mujoco.body import principal
from references.mujoco.engine import energies
from references.mujoco.steps import MUJOCO_EULER, MUJOCO_RK4
from tests.references.mujoco_problems import ALL, PROBLEMS, TILT, TILTED

every = pytest.mark.parametrize("contender", ALL, ids=lambda contender: contender.name)


def hat(w):
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


@cache
def truth(name: str) -> tuple[np.ndarray, np.ndarray]:
    """(q, v) after a time of 2, by DOP853 on matrices."""
    problem = PROBLEMS[name]
    system = problem.system

    def slope(t, y):
        if isinstance(system, galvi.Canonical):
            return [y[1], -system.potential.weight * np.sin(y[0]) / float(np.ravel(system.mass)[0])]
        R, w, J, x = y[:9].reshape(3, 3), y[9:12], system.inertia, y[12:]
        torque, drift = np.zeros(3), []
        if isinstance(system, galvi.FreeBody):
            drift = [R @ x[3:], np.cross(x[3:], w) + R.T @ system.g]
        elif system.potential is not None:
            weight = system.potential
            torque = np.cross(weight.centre, R.T @ (weight.mass * weight.g))
        turning = np.linalg.solve(J, np.cross(J @ w, w) + torque)
        return np.concatenate([(R @ hat(w)).ravel(), turning, *drift])

    q, v = problem.q0, problem.v0
    if isinstance(system, galvi.Canonical):
        start = np.concatenate([q, v])
    else:
        place = [q[:3, 3], v[3:]] if len(q) == 4 else []
        start = np.concatenate([q[:3, :3].ravel(), v[:3], *place])
    y = solve_ivp(slope, (0.0, 2.0), start, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    if isinstance(system, galvi.Canonical):
        return y[:1], y[1:]
    if len(q) == 3:
        return y[:9].reshape(3, 3), y[9:]
    end = np.eye(4)
    end[:3, :3], end[:3, 3] = y[:9].reshape(3, 3), y[12:15]
    return end, np.concatenate([y[9:12], y[15:]])


STEP, GOOD = 2.0**-10, 1e-10  # of RK4; 2e-11 of the heavy top, 1e-12 of the others


def disagreement(contender, name: str, step: float) -> float:
    """Largest error of q or of the velocity after a time of 2."""
    problem = PROBLEMS[name]
    run = contender.run(problem, 2.0, {"step": step, "save_every": 10**6})
    assert run.success
    q, v = truth(name)
    moved = problem.system.velocity(run.p[-1]) - v
    return float(max(np.abs(run.q[-1] - q).max(), np.abs(moved).max()))


@pytest.mark.parametrize("name", PROBLEMS)
def test_rk4_finds_the_motion(name):
    assert disagreement(MUJOCO_RK4, name, STEP) < GOOD


@pytest.mark.parametrize("name", PROBLEMS)
@every
def test_every_integrator_finds_the_motion(contender, name):
    step, tolerance = (2.0**-9, 2e-9) if contender.order == 4 else (2.0**-13, 5e-3)
    assert disagreement(contender, name, step) < tolerance  # 4e-10; 2e-3


@pytest.mark.parametrize("name", ["free body, tilted", "3D pendulum, skew", "thrown body, skew"])
@every
def test_the_order_of_the_attitude_is_what_is_claimed_and_no_more(contender, name):
    finest = 7 if contender.order == 4 else 12
    steps = 2.0 ** -np.arange(finest - 3, finest + 1)
    problem, attitude = PROBLEMS[name], truth(name)[0][:3, :3]
    runs = [contender.run(problem, 2.0, {"step": h, "save_every": 10**6}) for h in steps]
    errors = [np.abs(run.q[-1, :3, :3] - attitude).max() for run in runs]
    assert errors[-1] > 1e-10  # 2.5e-10: far above round-off
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - contender.order) < 0.05  # 0.025


@pytest.fixture
def wrong_for_once(monkeypatch):
    """A monkeypatch that leaves no model behind."""
    mujoco_engine.compiled.cache_clear()
    yield monkeypatch
    mujoco_engine.compiled.cache_clear()


def swapped(monkeypatch):
    """Quaternions with w last."""
    monkeypatch.setattr(mujoco_states, "FROM_SCIPY", [0, 1, 2, 3])
    monkeypatch.setattr(mujoco_states, "TO_SCIPY", [0, 1, 2, 3])


def transposed(monkeypatch):
    """The axes of inertia turned the other way."""

    def wrong(inertia):
        moments, axes = principal(inertia)
        return moments, axes * [1.0, -1.0, -1.0, -1.0]

    monkeypatch.setattr(mujoco_body, "principal", wrong)


def on_the_pivot(monkeypatch):
    """The inertia about the pivot taken for that about the centre of mass."""
    monkeypatch.setattr(
        mujoco_body, "on_a_pivot", lambda mass, centre, inertia: (mass, centre, *principal(inertia))
    )


def in_space(monkeypatch):
    """The body velocity of a body's centre taken for its velocity in space."""

    def wrong(joint, q, v):
        qpos, qvel = mujoco_states.to_mujoco(joint, q, v)
        return qpos, np.concatenate([v[3:], v[:3]]) if joint == "free" else qvel

    monkeypatch.setattr(mujoco_engine, "to_mujoco", wrong)


FAULTS = (
    (swapped, "free body, tilted"),
    (transposed, "free body, tilted"),
    (transposed, "3D pendulum, skew"),
    (on_the_pivot, "3D pendulum, skew"),
    (on_the_pivot, "heavy top"),
    (in_space, "thrown body, skew"),
)


@pytest.mark.parametrize(("fault", "name"), FAULTS, ids=lambda x: getattr(x, "__name__", x))
def test_a_wrong_convention_is_caught(fault, name, wrong_for_once):
    fault(wrong_for_once)
    assert disagreement(MUJOCO_RK4, name, STEP) > 1e-2


def test_a_diagonal_inertia_from_upright_would_not_have_shown_the_axes(wrong_for_once):
    transposed(wrong_for_once)
    assert disagreement(MUJOCO_RK4, "free body", STEP) < GOOD


@every
def test_keeping_fewer_states_or_cutting_a_run_does_not_change_them(contender, monkeypatch):
    whole = contender.run(TILTED, 1.0, {"step": 0.01})
    seventh = contender.run(TILTED, 1.0, {"step": 0.01, "save_every": 7})
    kept = [*range(0, 100, 7), 100]
    assert np.array_equal(seventh.q, whole.q[kept]) and np.array_equal(seventh.p, whole.p[kept])
    assert np.array_equal(seventh.t, whole.t[kept]) and whole.counts == {"steps": 100}
    monkeypatch.setattr(mujoco_steps, "CHUNK", 3)
    assert np.array_equal(contender.run(TILTED, 1.0, {"step": 0.01, "save_every": 7}).q, seventh.q)


def test_runs_of_different_problems_do_not_touch_each_other():
    first = MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.01})
    MUJOCO_EULER.run(TILTED, 1.0, {"step": 0.05})
    MUJOCO_RK4.run(PROBLEMS["heavy top"], 1.0, {"step": 0.02})
    assert np.array_equal(MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.01}).q, first.q)


def test_time_runs_backwards():
    end, v = truth("3D pendulum, skew")
    back = galvi.Problem(PROBLEMS["3D pendulum, skew"].system, end, v, t0=7.0)
    run = MUJOCO_RK4.run(back, -2.0, {"step": -(2.0**-9), "save_every": 512})
    np.testing.assert_allclose(run.q[-1], TILT, atol=1e-10)  # 9e-12
    assert np.array_equal(run.t, [7.0, 6.0, 5.0])


@pytest.mark.parametrize("every_n", [1, 4, 100])
def test_a_run_that_blows_up_says_where_and_leaves_nothing_behind(
    every_n, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    told = mujoco.get_mju_user_warning()
    fast = galvi.Problem(TILTED.system, TILT, [20.0, -19.0, 10.0])
    run = MUJOCO_EULER.run(fast, 50.0, {"step": 0.5, "save_every": every_n})
    assert not run.success and run.failed_step == 5 and "Step 5, towards t = " in run.status
    assert run.counts["steps"] == 4 and run.status.endswith("another integrator.")
    done = np.append(np.arange(0, 100, every_n), 100) < run.failed_step
    for states in (run.q, run.p, energies(run)):
        assert np.all(np.isfinite(states[done])) and np.all(np.isnan(states[~done]))
    assert capfd.readouterr() == ("", "") and not list(Path(tmp_path).iterdir())
    assert mujoco.get_mju_user_warning() is told
    assert MUJOCO_EULER.run(fast, 1.0, {"step": 1e-3}).success  # no warning is left over
