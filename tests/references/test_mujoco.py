"""MuJoCo against equations of motion written here, its orders, its failures and its frames."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import galvi

pytest.importorskip("mujoco")

import mujoco

from references import mujoco_body, mujoco_engine, mujoco_states, mujoco_steps
from references.mujoco_body import on_a_pivot, principal
from references.mujoco_engine import energies
from references.mujoco_steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)

ALL = (MUJOCO_EULER, MUJOCO_RK4, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)
if MUJOCO_RK4.missing:
    pytest.skip(MUJOCO_RK4.missing, allow_module_level=True)
every = pytest.mark.parametrize("contender", ALL, ids=lambda contender: contender.name)

TILT = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
SKEW = np.array([[3.3, 0.2, -0.3], [0.2, 2.5, 0.4], [-0.3, 0.4, 3.4]])
SPIN = [2.0, -1.9, 1.0]
MOTION = np.block([[TILT, np.array([[0.5], [-1.0], [2.0]])], [np.zeros((1, 3)), np.ones((1, 1))]])
LEVER = galvi.UniformGravity(0.8, (0.3, -0.5, 0.7), (1.0, 2.0, -7.0))
TILTED = galvi.Problem(galvi.RigidBody(SKEW), TILT, SPIN)
PROBLEMS = {
    "free body": galvi.problems.free_rigid_body(),
    "free body, tilted": TILTED,
    "free box": galvi.problems.free_box(),
    "3D pendulum": galvi.problems.pendulum_3d(),
    "3D pendulum, skew": galvi.Problem(galvi.RigidBody(SKEW, LEVER), TILT, SPIN),
    "heavy top": galvi.problems.heavy_top(),
    "spherical pendulum": galvi.problems.spherical_pendulum(),
    "thrown body": galvi.problems.free_body_se3(g=(0.5, -1.0, -9.81)),
    "thrown body, skew": galvi.Problem(
        galvi.FreeBody(1.7, SKEW, (1.0, 2.0, -7.0)), MOTION, [*SPIN, 0.3, 0.2, -0.1]
    ),
    "planar pendulum": galvi.problems.planar_pendulum(),
    "planar pendulum, light": galvi.Problem(
        galvi.Canonical([[0.3]], galvi.PendulumWeight(1.7)), [-1.0], [2.0]
    ),
}


def hat(w):
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def truth(problem: galvi.Problem, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """(q, v) at the end, by DOP853 on matrices."""
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
    y = solve_ivp(slope, (0.0, duration), start, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    if isinstance(system, galvi.Canonical):
        return y[:1], y[1:]
    if len(q) == 3:
        return y[:9].reshape(3, 3), y[9:]
    end = np.eye(4)
    end[:3, :3], end[:3, 3] = y[:9].reshape(3, 3), y[12:15]
    return end, np.concatenate([y[9:12], y[15:]])


STEP, GOOD = 2.0**-10, 1e-10  # of RK4; 2e-11 of the heavy top, 1e-12 of the others
TRUTHS = {name: truth(problem, 2.0) for name, problem in PROBLEMS.items()}


def disagreement(contender, name: str, step: float) -> float:
    """Largest error of q or of the velocity after a time of 2."""
    problem = PROBLEMS[name]
    run = contender.run(problem, 2.0, {"step": step, "save_every": 10**6})
    assert run.success
    q, v = TRUTHS[name]
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
    problem, attitude = PROBLEMS[name], TRUTHS[name][0][:3, :3]
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

    monkeypatch.setattr(mujoco_steps, "to_mujoco", wrong)


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


@pytest.mark.parametrize(
    ("mass", "centre", "inertia"),
    [
        (0.8, [0.3, -0.5, 0.7], SKEW),
        (1.0, [0.0, 0.0, 1.0], np.diag([1.0, 1.0, 1e-3])),  # a point on a thin rod
        (1.0, [1.0, 0.0, 0.0], np.diag([0.25, 1.25, 1.5])),  # a disc that swings in its plane
        (3.0, [0.6, 0.8, 0.0], TILT @ np.diag([5.0, 7.0, 9.0]) @ TILT.T),
    ],
)
def test_a_pivoted_body_has_the_inertia_and_the_weight_that_were_given(mass, centre, inertia):
    m, r, moments, axes = on_a_pivot(mass, np.array(centre), inertia)
    A = Rotation.from_quat(axes[[1, 2, 3, 0]]).as_matrix()
    about = A @ np.diag(moments) @ A.T + m * (r @ r * np.eye(3) - np.outer(r, r))
    np.testing.assert_allclose(about, inertia, rtol=0, atol=1e-14 * np.abs(inertia).max())
    assert np.array_equal(m * r, mass * np.array(centre))
    assert np.all(moments > 0.0) and 2.0 * moments.max() <= moments.sum()


def test_the_model_has_the_numbers_bit_for_bit():
    system = PROBLEMS["3D pendulum, skew"].system
    body = mujoco_body.mujoco_body(system)
    _, model, _ = mujoco_engine.compiled(system)
    assert np.array_equal(model.body_inertia[1], body.moments)
    assert np.array_equal(model.body_ipos[1], body.centre)
    assert np.array_equal(model.opt.gravity, body.gravity) and model.body_mass[1] == body.mass


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
    end, v = TRUTHS["3D pendulum, skew"]
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


@pytest.mark.parametrize("name", PROBLEMS)
def test_mujocos_own_energies_are_those_of_the_problem(name):
    problem = PROBLEMS[name]
    run = MUJOCO_RK4.run(problem, 1.0, {"step": 2.0**-9, "save_every": 64})
    potential, kinetic = energies(run).T
    system = problem.system
    size = kinetic.max() + np.abs(potential).max()
    ours = 0.5 * np.sum(run.p * system.velocity(run.p), axis=-1)
    np.testing.assert_allclose(kinetic, ours, atol=1e-14 * size)  # 2e-15
    np.testing.assert_allclose(potential, system.potential_energy(run.q, run.t), atol=1e-14 * size)
    total = potential + kinetic
    assert np.abs(total - total[0]).max() < 1e-11 * size  # 1e-12


@pytest.mark.parametrize(
    "problem",
    [
        galvi.Problem(galvi.RigidBody(SKEW, lambda R: R[2, 2]), TILT, SPIN),
        galvi.Problem(galvi.RigidBody(SKEW, LEVER, lambda R: 0.0 * R), TILT, SPIN),
        galvi.Problem(galvi.Canonical(1.0, galvi.PendulumWeight(1.0)), [1.0, 2.0], [0.0, 0.0]),
        galvi.Problem(
            galvi.Canonical(1.0, galvi.PendulumWeight(1.0), lambda q: q), [1.0], [0.0]
        ),
        galvi.problems.kepler(),
    ],
    ids=["any potential", "a gradient of its own", "two pendulums", "another force", "no body"],
)  # fmt: skip
def test_other_problems_are_not_taken(problem):
    assert not any(contender.supports(problem) for contender in ALL)
    with pytest.raises(ValueError, match="MuJoCo RK4 does not solve"):
        MUJOCO_RK4.run(problem, 1.0, {"step": 0.1})


def test_a_body_that_mujoco_refuses_is_a_sentence():
    tiny = galvi.Problem(galvi.RigidBody(1e-18 * SKEW), TILT, SPIN)
    with pytest.raises(
        ValueError, match=r"^MuJoCo refuses this body: .*mjMINVAL.*Give it in units"
    ):
        MUJOCO_RK4.run(tiny, 1.0, {"step": 0.1})


def test_an_absent_or_old_mujoco_is_a_sentence(monkeypatch):
    for found, word in ((None, "mujoco"), ("4.0.0", "4.0.0 has known"), ("3.17.0", "3.17.0")):
        fake = None if found is None else SimpleNamespace(__version__=found)
        monkeypatch.setitem(sys.modules, "mujoco", fake)
        assert word in MUJOCO_RK4.missing
        assert MUJOCO_RK4.missing.endswith("Install mujoco-core 4.0.1 or newer.")
        with pytest.raises(ModuleNotFoundError, match=r"MuJoCo RK4 cannot run: .*mujoco"):
            MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.1})


def test_an_integrator_that_a_version_has_not_is_missing(monkeypatch):
    fake = SimpleNamespace(__version__="10.0", mjtIntegrator=SimpleNamespace(mjINT_RK4=1))
    monkeypatch.setitem(sys.modules, "mujoco", fake)
    assert MUJOCO_RK4.missing == ""
    assert MUJOCO_DISCRETE.missing == "mujoco 10.0 has no integrator discrete."


def test_the_version_is_in_the_method():
    run = MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.1})
    assert run.method == f"MuJoCo RK4 step=0.1 (mujoco {mujoco.__version__})"
