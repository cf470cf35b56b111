"""MuJoCo against equations of motion written here: its bodies, trees, orders, runs and frames."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from itertools import cycle
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from references.closed_forms.pendulum import PENDULUM
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.mujoco import body, engine, steps
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.body import MujocoTree, principal
from references.mujoco.steps import (
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853
from tests.properties.random_trees import random_state, random_tree
from tests.properties.tree_equations import defects

mujoco = pytest.importorskip("mujoco")
OTHER_INTEGRATORS = (MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)
INTEGRATORS = (MUJOCO_RK4, *OTHER_INTEGRATORS)

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
        galvi.Canonical([[0.3]], galvi.CosinePotential(1.7)), [-1.0], [2.0]
    ),
}
every_contender = pytest.mark.parametrize(
    "contender", INTEGRATORS, ids=lambda contender: contender.name
)


@cache
def truth(name: str) -> tuple[np.ndarray, np.ndarray]:
    """(q, v) after a time of 2, in closed form or by SciPy's DOP853."""
    problem = PROBLEMS[name]
    exact = (PENDULUM, FREE_TOP, THROWN_BODY, RIGID_DOP853, DOP853)
    contender = next(reference for reference in exact if reference.supports(problem))
    run = contender.run(problem, 2.0, {} if contender.exact else TIGHT)
    return run.q[-1], problem.system.velocity(run.p[-1])


RK4_STEP, RK4_BOUND = 2.0**-10, 1e-10  # errors: 2e-11 for the heavy top, 1e-12 for the others


def disagreement(contender, name: str, step: float) -> float:
    """Largest error of q or of the velocity after a time of 2."""
    problem = PROBLEMS[name]
    run = contender.run(problem, 2.0, {"step": step, "save_every": 10**6})
    assert run.success
    q, v = truth(name)
    velocity_error = problem.system.velocity(run.p[-1]) - v
    return float(max(np.abs(run.q[-1] - q).max(), np.abs(velocity_error).max()))


@pytest.mark.parametrize(("name", "contender"), [*zip(PROBLEMS, cycle(OTHER_INTEGRATORS))])
def test_integrators_find_the_motion(name, contender):
    assert disagreement(MUJOCO_RK4, name, RK4_STEP) < RK4_BOUND
    assert disagreement(contender, name, 2.0**-13) < 5e-3  # 2e-3


@pytest.mark.parametrize("name", ["free body, tilted", "3D pendulum, skew", "thrown body, skew"])
@every_contender
def test_the_order_of_the_attitude_is_what_is_claimed_and_no_more(contender, name):
    finest = 7 if contender.order == 4 else 12
    sizes = 2.0 ** -np.arange(finest - 3, finest + 1)
    problem, attitude = PROBLEMS[name], truth(name)[0][:3, :3]
    runs = [contender.run(problem, 2.0, {"step": h, "save_every": 10**6}) for h in sizes]
    errors = [np.abs(run.q[-1, :3, :3] - attitude).max() for run in runs]
    assert errors[-1] > 1e-10  # 2.5e-10: far above round-off
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert abs(slope - contender.order) < 0.05  # 0.025


@pytest.fixture
def patched_models(monkeypatch):
    """A monkeypatch; the cache of compiled models is empty before and after."""
    engine.compiled.cache_clear()
    yield monkeypatch
    engine.compiled.cache_clear()


def swapped(monkeypatch):
    """Quaternions with w last."""
    monkeypatch.setattr(body, "FROM_SCIPY", [0, 1, 2, 3])
    monkeypatch.setattr(body, "TO_SCIPY", [0, 1, 2, 3])


def transposed(monkeypatch):
    """The axes of inertia turned the other way."""

    def wrong(inertia):
        moments, axes = principal(inertia)
        return moments, axes * [1.0, -1.0, -1.0, -1.0]

    monkeypatch.setattr(body, "principal", wrong)


def on_the_pivot(monkeypatch):
    """The inertia about the pivot taken for that about the centre of mass."""
    monkeypatch.setattr(
        body, "on_a_pivot", lambda mass, centre, inertia: (mass, centre, *principal(inertia))
    )


def in_space(monkeypatch):
    """The body velocity of a body's centre taken for its velocity in space."""

    def wrong(joint, q, v):
        qpos, qvel = body.to_mujoco(joint, q, v)
        return qpos, np.concatenate([v[3:], v[:3]]) if joint == "free" else qvel

    monkeypatch.setattr(engine, "to_mujoco", wrong)


FAULTS = (
    (swapped, "free body, tilted"),
    (transposed, "free body, tilted"),
    (transposed, "3D pendulum, skew"),
    (on_the_pivot, "3D pendulum, skew"),
    (on_the_pivot, "heavy top"),
    (in_space, "thrown body, skew"),
)


@pytest.mark.parametrize(("fault", "name"), FAULTS, ids=lambda x: getattr(x, "__name__", x))
def test_a_wrong_convention_is_caught(fault, name, patched_models):
    fault(patched_models)
    assert disagreement(MUJOCO_RK4, name, RK4_STEP) > 1e-2


@every_contender
def test_keeping_fewer_states_or_cutting_a_run_does_not_change_them(contender, monkeypatch):
    full = contender.run(TILTED, 1.0, {"step": 0.01})
    seventh = contender.run(TILTED, 1.0, {"step": 0.01, "save_every": 7})
    saved_steps = [*range(0, 100, 7), 100]
    assert np.array_equal(seventh.q, full.q[saved_steps]) and np.array_equal(
        seventh.p, full.p[saved_steps]
    )
    assert np.array_equal(seventh.t, full.t[saved_steps]) and full.counts == {"steps": 100}
    monkeypatch.setattr(steps, "CHUNK", 3)
    assert np.array_equal(contender.run(TILTED, 1.0, {"step": 0.01, "save_every": 7}).q, seventh.q)


def test_runs_of_different_problems_do_not_touch_each_other():
    first = MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.01})
    assert first.method == f"MuJoCo RK4 step=0.01 (mujoco {mujoco.__version__})"
    MUJOCO_EULER.run(TILTED, 1.0, {"step": 0.05})
    MUJOCO_RK4.run(PROBLEMS["heavy top"], 1.0, {"step": 0.02})
    assert np.array_equal(MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.01}).q, first.q)


def test_time_runs_backwards():
    final_attitude, v = truth("3D pendulum, skew")
    reversed_problem = galvi.Problem(
        PROBLEMS["3D pendulum, skew"].system, final_attitude, v, t0=7.0
    )
    run = MUJOCO_RK4.run(reversed_problem, -2.0, {"step": -(2.0**-9), "save_every": 512})
    np.testing.assert_allclose(run.q[-1], TILT, atol=1e-10)  # 9e-12
    assert np.array_equal(run.t, [7.0, 6.0, 5.0])


@pytest.mark.parametrize("save_every", [1, 4, 100])
def test_a_run_that_blows_up_says_where_and_leaves_nothing_behind(
    save_every, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    handler = mujoco.get_mju_user_warning()
    fast = galvi.Problem(TILTED.system, TILT, [20.0, -19.0, 10.0])
    run = MUJOCO_EULER.run(fast, 50.0, {"step": 0.5, "save_every": save_every})
    assert not run.success and run.failed_step == 5 and "Step 5, towards t = " in run.status
    assert run.counts["steps"] == 4 and run.status.endswith("another integrator.")
    completed = np.append(np.arange(0, 100, save_every), 100) < run.failed_step
    for states in (run.q, run.p, engine.energies(run)):
        assert np.all(np.isfinite(states[completed])) and np.all(np.isnan(states[~completed]))
    assert capfd.readouterr() == ("", "") and not list(Path(tmp_path).iterdir())
    assert mujoco.get_mju_user_warning() is handler
    assert MUJOCO_EULER.run(fast, 1.0, {"step": 1e-3}).success  # no warning is left over


@pytest.mark.parametrize("name", PROBLEMS)
def test_mujocos_own_energies_are_those_of_the_problem(name):
    problem = PROBLEMS[name]
    run = MUJOCO_RK4.run(problem, 1.0, {"step": 2.0**-9, "save_every": 64})
    potential, kinetic = engine.energies(run).T
    system = problem.system
    size = kinetic.max() + np.abs(potential).max()
    kinetic_energy = 0.5 * np.sum(run.p * system.velocity(run.p), axis=-1)
    np.testing.assert_allclose(kinetic, kinetic_energy, atol=1e-14 * size)  # 2e-15
    np.testing.assert_allclose(potential, system.potential_energy(run.q, run.t), atol=1e-14 * size)
    total = potential + kinetic
    assert np.abs(total - total[0]).max() < 1e-11 * size  # 1e-12


@pytest.mark.parametrize(
    "problem",
    [
        galvi.Problem(galvi.RigidBody(SKEW, lambda R: R[2, 2]), TILT, SPIN),
        galvi.Problem(galvi.RigidBody(SKEW, LEVER, lambda R: 0.0 * R, check=False), TILT, SPIN),
        galvi.Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), [1.0, 2.0], [0.0, 0.0]),
        galvi.Problem(
            galvi.Canonical(1.0, galvi.CosinePotential(1.0), lambda q: q, check=False), [1.0], [0.0]
        ),
        galvi.problems.kepler(),
    ],
    ids=["any potential", "a gradient of its own", "two pendulums", "another force", "no body"],
)
def test_other_problems_are_not_taken(problem):
    assert not any(contender.supports(problem) for contender in INTEGRATORS)
    with pytest.raises(ValueError, match="MuJoCo RK4 does not solve"):
        MUJOCO_RK4.run(problem, 1.0, {"step": 0.1})


def test_a_body_that_mujoco_refuses_is_a_sentence():
    tiny = galvi.Problem(galvi.RigidBody(1e-18 * SKEW), TILT, SPIN)
    with pytest.raises(
        ValueError, match=r"^MuJoCo refuses this body: .*mjMINVAL.*Give it in units"
    ):
        MUJOCO_RK4.run(tiny, 1.0, {"step": 0.1})


def test_what_an_absent_or_old_mujoco_has_not_is_a_sentence(monkeypatch):
    for version, word in ((None, "mujoco"), ("4.0.0", "4.0.0 has known"), ("3.17.0", "3.17.0")):
        fake = None if version is None else SimpleNamespace(__version__=version)
        monkeypatch.setitem(sys.modules, "mujoco", fake)
        assert word in MUJOCO_RK4.missing
        assert MUJOCO_RK4.missing.endswith("Install mujoco-core 4.0.1 or newer.")
        with pytest.raises(ModuleNotFoundError, match=r"MuJoCo RK4 cannot run: .*mujoco"):
            MUJOCO_RK4.run(TILTED, 1.0, {"step": 0.1})
    fake = SimpleNamespace(__version__="10.0", mjtIntegrator=SimpleNamespace(mjINT_RK4=1))
    monkeypatch.setitem(sys.modules, "mujoco", fake)
    assert MUJOCO_RK4.missing == ""
    assert MUJOCO_DISCRETE.missing == "mujoco 10.0 has no integrator discrete."


EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
ARM, FLOATING = galvi.problems.skew_arm(damping=0.2), galvi.problems.skew_arm(floating=True)


@settings(max_examples=30)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_a_tree_written_as_mjcf_is_the_same_tree(joints, seed):
    system = galvi.from_mujoco(random_tree(joints, seed)).system
    model = mujoco.MjModel.from_xml_string(MujocoTree(system).mjcf())
    assert np.max(defects(model, system, *random_state(model, seed))[[0, 2]]) < 1e-11


@pytest.mark.slow_cases("floating arm")
@pytest.mark.parametrize("problem", [ARM, FLOATING], ids=lambda problem: problem.name)
def test_dop853_on_mujoco_s_accelerations_finds_galvi_s_motion(problem):
    by_galvi = galvi.integrate(problem, EIGHT, 0.01, 50)
    by_mujoco = MUJOCO_ACCELERATIONS.run(problem, 0.5, {"samples": 2})
    assert (
        by_mujoco.success and np.max(np.abs(by_mujoco.q[1:] - by_galvi.q[25::25])) < 1e-12
    )  # 1e-14
    assert np.max(np.abs(by_mujoco.p[1:] - by_galvi.p[25::25])) < 1e-11


def test_a_tree_with_an_anchor_on_the_other_side_would_be_seen():
    system = galvi.from_mujoco(random_tree(4, 3, kinds=("hinge",))).system
    links = [
        replace(link, joints=[replace(joint, anchor=-joint.anchor) for joint in link.joints])
        for link in system.links
    ]
    model = mujoco.MjModel.from_xml_string(MujocoTree(system).mjcf())
    wrong = galvi.Multibody(links, system.gravity)
    assert defects(model, wrong, *random_state(model, 1))[0] > 1e-3


def test_a_spring_that_mjcf_cannot_say_is_not_taken():
    quarter_turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for rest_rotation, supported in ((None, True), (quarter_turn, False)):
        ball = galvi.Joint("ball", stiffness=1.0, rest=rest_rotation)
        system = galvi.Multibody(galvi.Link(ball, 1.0, (0, 0, 1), (0.1, 0.1, 0.1)))
        problem = galvi.Problem(system, np.eye(3), [0.0, 0.0, 1.0])
        assert MUJOCO_RK4.supports(problem) is MUJOCO_ACCELERATIONS.supports(problem) is supported
