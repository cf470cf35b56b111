"""Judging trees of rigid bodies: errors of their joints, for a pendulum against its closed form."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from benchmarks.applications.judging import trees
from benchmarks.applications.judging.candidate import Kind, Model
from benchmarks.applications.judging.judgement import Judgement, judge, own_setting
from galvi import Problem
from galvi.interop import from_mujoco
from galvi.interop.rebound import read
from references import as_trajectory, engine_clock
from references.closed_forms.pendulum import PENDULUM
from references.mujoco import body
from references.pinocchio.tree import PINOCCHIO_ACCELERATIONS
from reports.judge.sentences import sentences

mujoco = pytest.importorskip("mujoco")
ROOT = Path(__file__).parents[3]


def swing(damping: float = 0.0, **overrides: object) -> Problem:
    """A ball of 1 kg at 1 m from a hinge, which swings from 2 radians; its moment is 1.01."""
    hinge = galvi.Joint("hinge", axis=(0.0, 1.0, 0.0), damping=damping)
    rod = galvi.Link(hinge, mass=1.0, centre=(0.0, 0.0, -1.0), inertia=(0.01,) * 3, name="rod")
    system = galvi.Multibody([rod])
    q, v = system.from_mujoco([2.0], [0.0])
    return Problem(system, q, v, parameters={"integrator": "RK4", "dt": 0.02, **overrides})


@pytest.fixture(scope="module")
def judgement() -> Judgement:
    return judge(swing(), duration=10.0, error=1e-6)


def test_the_error_of_a_pendulum_is_that_against_the_closed_form(judgement: Judgement) -> None:
    plain = galvi.Problem(galvi.Canonical(1.01, galvi.CosinePotential(9.81)), [2.0], [0.0])
    exact = PENDULUM.run(plain, judgement.duration, {"samples": 100})
    rk4_run = trees.INTEGRATORS["rk4"].run(swing(), 10.0, {"step": 0.02, "save_every": 5})
    rk4_error = np.abs(rk4_run.q - exact.q).max()
    assert judgement.own["error"] == pytest.approx(rk4_error, rel=1e-4)
    assert judgement.truth_agreement < 1e-9 and judgement.own["energy"] > 0.0
    assert list(judgement.parts["joint"]) == ["hinge of rod"]
    assert judgement.recommended is not None and judgement.recommended["error"] <= 1e-6
    integrators = judgement.table["integrator"].drop_duplicates().tolist()
    assert {"MuJoCo RK4 (yours)", "MuJoCo Euler", "galvi degree 8, Gauss 8"} <= {*integrators}
    assert "MuJoCo RK4" not in integrators  # the same model with the same options
    assert len(judgement.encounters.columns) == 0


def test_where_sources_part_nothing_is_judged(judgement: Judgement) -> None:
    """Planted: a source that leaves the truth after 4 s."""
    assert math.isinf(judgement.trusted_until) and "part" not in sentences(judgement)[1]
    agreement = judgement.agreements[0]
    parted = replace(agreement, distances=np.where(agreement.t > 4.0, 0.1, agreement.distances))
    wrong = replace(judgement, agreements=(parted, *judgement.agreements[1:]))
    assert wrong.trusted_until == 4.0
    assert "After t = 4 the sources part, and nothing can be judged" in sentences(wrong)[1]
    opinion = replace(parted, source=judgement.agreements[-1].source)
    assert math.isinf(replace(judgement, agreements=(opinion,)).trusted_until)


def test_the_page_says_where_all_sources_are_of_one_engine(judgement: Judgement) -> None:
    assert "runs of galvi are never the truth" in sentences(judgement)[1]
    note = "rests on one engine, MuJoCo: install the extra trees (pip install pin) for Pinocchio"
    assert (note in sentences(judgement)[1]) is bool(PINOCCHIO_ACCELERATIONS.missing)
    first, *later = judgement.agreements
    second = replace(first, source=replace(first.source, label="another", engine="Pinocchio"))
    assert note not in sentences(replace(judgement, agreements=(second, *later)))[1]


@pytest.mark.slow(beside="test_a_damped_hinge_is_judged_with_the_damping_of_its_integrator")
def test_a_damped_tree_has_no_energy_error() -> None:
    judgement = judge(swing(damping=0.1), duration=5.0, own={"integrator": "implicitfast"})
    assert math.isnan(judgement.own["energy"]) and math.isnan(judgement.own["momentum"])
    assert judgement.own["integrator"] == "MuJoCo implicitfast, dt = 0.02" and judgement.passed


def test_errors_of_balls_and_free_bodies_are_angles_and_lengths() -> None:
    links = [
        galvi.Link(galvi.Joint(joint_type), mass=1.0, inertia=(1.0, 2.0, 2.5))
        for joint_type in ("ball", "free")
    ]
    system = galvi.Multibody(links)
    half = 0.15  # half an angle of 0.3 about x
    left, right = np.zeros((2, 11))
    left[[0, 7]] = 1.0
    right[:2] = math.cos(half), math.sin(half)
    right[4:7], right[7] = (0.0, 0.4, 0.0), -1.0  # the same attitude
    runs = []
    for qpos in (left, right):
        q, v = system.from_mujoco(qpos, np.zeros(9))
        runs.append(galvi.Trajectory(Problem(system, q, v), np.zeros(1), q[None], v[None]))
    assert trees.errors(*runs)[0] == pytest.approx([0.3, 0.4], rel=1e-12)
    assert trees.names(runs[0].problem) == ["ball of link 0", "free of link 1"]


def test_a_start_at_which_nothing_moves_is_refused() -> None:
    still = swing().with_initial_state(*swing().system.from_mujoco([0.0], [0.0]))
    with pytest.raises(ValueError, match=r"nothing moves from this start: .*--key 0"):
        judge(still)


FLOATING_ARM = (ROOT / "docs" / "models" / "floating_arm.xml").read_text()


@pytest.mark.parametrize(
    ("start", "note_count"),
    [({}, 1), ({"key": 0}, 0), ({"qvel": [0.0] * 9}, 1), ({"qvel": [0.0] * 8 + [0.1]}, 0)],
)
def test_a_floating_model_that_only_falls_is_told(start: dict[str, Any], note_count: int) -> None:
    text = FLOATING_ARM.replace('gravity="0 0 0"', "")
    problem, _ = from_mujoco.read(text, (), start.get("key"), None, start.get("qvel"))
    truth = trees.INTEGRATORS["rk4"].run(problem, 1.0, {"step": 0.001, "save_every": 100})
    setting = own_setting(cast(Kind, trees), Model(problem), {})
    notes = trees.notes(Model(problem), setting, truth)
    assert len(notes) == note_count
    assert all("moves as one rigid body" in note and "--key" in note for note in notes)


@pytest.mark.slow(
    beside="tests/suite/reports/test_judge.py::test_only_an_error_that_was_asked_for_is_a_failure_and_an_unconfirmed_truth_is_none"
)
def test_a_run_that_fails_is_told_and_has_no_error() -> None:
    stiff = swing(damping=1000.0)  # beyond the stability of RK4 with its steps
    judgement = judge(stiff, duration=1.0, error=1e-6)
    assert math.isnan(judgement.own["error"]) and "unstable" in judgement.own["status"]
    assert not judgement.passed and np.isfinite(judgement.parts["largest_error"]).all()


MOTOR = """<mujoco><option timestep=".002" integrator="implicitfast" {}/><worldbody><body>
<joint name="h" axis="0 1 0" damping=".1"/><inertial pos="0 0 -.4" mass="1"
diaginertia=".02 .03 .01"/></body></worldbody>{}<keyframe><key qpos="1"/></keyframe></mujoco>"""
ACTING = {
    "a motor": ("", '<actuator><motor joint="h"/></actuator>'),
    "a medium": ('density="100" viscosity=".1"', ""),
    "a tendon": ("", '<tendon><fixed stiffness="3"><joint joint="h" coef="1"/></fixed></tendon>'),
}


@pytest.mark.parametrize("name", ACTING)
def test_all_of_mujocos_integrators_are_tried_on_a_model_with_forces(name: str) -> None:
    """The user's own model is asked, not one that is made of the problem, which none can run."""
    engine_model, problem = from_mujoco.read(MOTOR.format(*ACTING[name]), key=0)[::-1]
    model = Model(problem, engine_model)
    setting = own_setting(cast(Kind, trees), model, {})
    labels = [group[0].label for group in trees.candidates(model, 2.0, setting)]
    available = {
        contender.name for contender in trees.INTEGRATORS.values() if not contender.missing
    }
    assert available - {setting.name} <= {*labels}


HINGE = """<mujoco><option timestep="0.002" integrator="{integrator}"/><worldbody><body>
<joint axis="0 1 0" damping="{damping}"/>
<inertial pos="0 0 -.1" mass=".1" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody>
<keyframe><key name="up" qpos="1"/></keyframe></mujoco>"""


def hinge(damping: float, integrator: str = "Euler") -> Any:
    return mujoco.MjModel.from_xml_string(HINGE.format(damping=damping, integrator=integrator))


def judged_model(
    model: Any, duration: float, error: float | None = None, **start: Any
) -> Judgement:
    problem, engine_model = from_mujoco.read(model, (), start.pop("key", 0), **start)
    return judge(Model(problem, engine_model), duration, error, quick=True)


@pytest.mark.slow_cases(but=["0.1-0.000291"])
@pytest.mark.parametrize(
    ("damping", "error"),
    [(0.01, 2.76e-3), (0.1, 2.91e-4), (0.5, 4.39e-5), (2.0, 4.30e-6), (3.0, 1.52e-6)],
)
def test_a_damped_hinge_is_judged_with_the_damping_of_its_integrator(
    damping: float, error: float
) -> None:
    """Right values: mj_step against SciPy's Radau at 1e-12, written by hand, over 1 s."""
    judgement = judged_model(hinge(damping), 1.0, 1e-4)
    assert judgement.own["error"] == pytest.approx(error, rel=2e-3)
    assert judgement.passed is bool(error <= 1e-4)


def test_a_rebuilt_model_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the run of a model that was built from the problem, without implicit damping."""
    monkeypatch.setattr(trees, "own_contender", lambda model, name: trees.INTEGRATORS[name])
    document = body.document
    monkeypatch.setattr(
        body,
        "document",
        lambda gravity, links, disabled: document(gravity, links, (*disabled, "eulerdamp")),
    )
    judgement = judged_model(hinge(0.5), 1.0, 1e-4)
    with pytest.raises(AssertionError):
        assert judgement.own["error"] == pytest.approx(4.39e-5, rel=2e-3)


@settings(max_examples=15, deadline=None)
@given(
    st.sampled_from(["Euler", "RK4", "implicit", "implicitfast", "discrete"]),
    st.booleans(),
    st.floats(0.0, 1.0),
    st.sampled_from([0.001, 0.004]),
)
def test_an_own_run_is_mj_steps_to_the_last_bit(
    integrator: str, eulerdamp: bool, damping: float, timestep: float
) -> None:
    model = hinge(damping, integrator)
    model.opt.timestep = timestep
    if not eulerdamp:
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    problem, engine_model = from_mujoco.read(model, (), 0)
    setting = own_setting(trees, Model(problem, engine_model), {})
    run = setting.contender.run(problem, 12 * timestep, {"step": timestep, "save_every": 4})
    state = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, state, 0)
    for row in range(1, 4):
        mujoco.mj_step(model, state, nstep=4)
        assert run.q[row, 0] == state.qpos[0]


def test_a_time_is_the_engines_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: a conversion by galvi that advances the clock by 1000 s."""
    added_seconds, real = 0.0, time.perf_counter

    def clock() -> float:
        return real() + added_seconds

    def slow(*arguments: Any, **keywords: Any) -> Any:
        nonlocal added_seconds
        added_seconds += 1000.0
        return converted(*arguments, **keywords)

    converted = as_trajectory.momentum_at
    monkeypatch.setattr(as_trajectory, "momentum_at", slow)
    monkeypatch.setattr("benchmarks.applications.judging.clock.time.perf_counter", clock)
    assert engine_clock.time.perf_counter is clock
    sim = pytest.importorskip("rebound").Simulation()
    for particle in ({"m": 1e-3, "x": 1.0, "vy": 1.0}, {"m": 1.0}):
        sim.add(**particle)
    sim.integrator, sim.dt = "whfast", 0.05
    points = Model(*read(sim, -1))
    for judgement in (judge(points, 5.0, quick=True), judged_model(hinge(0.1), 0.2)):
        assert added_seconds >= 1000.0 and judgement.own["seconds"] < 500.0
        engines = judgement.table[~judgement.table["integrator"].str.startswith("galvi")]
        assert (engines["seconds"].dropna() < 500.0).all()


def test_joints_have_their_names() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body name="waist">
    <joint name="abdomen_y" axis="0 1 0"/><joint axis="1 0 0"/><joint axis="0 0 1"/>
    <inertial pos="0 0 -.1" mass=".1" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody></mujoco>""")
    problem, _ = from_mujoco.read(model, (), None, qpos=[0.5, 0.1, 0.0])
    names = ["abdomen_y", "hinge 2 of waist", "hinge 3 of waist"]
    assert trees.names(problem) == names == trees.entries(problem)


def test_a_start_may_be_given_in_the_engines_numbers() -> None:
    judgement = judged_model(hinge(0.0), 0.2, 1e-3, key=None, qpos=[0.7], qvel=[0.1])
    assert judgement.problem.q0 == pytest.approx([0.7]) and judgement.problem.v0 == pytest.approx(
        [0.1]
    )
    assert math.isfinite(judgement.own["error"])


def test_a_misread_model_is_refused_along_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: a reading that is right at the start only."""
    problem, engine_model = from_mujoco.read(hinge(0.0), (), 0)
    engine_model.model.jnt_stiffness[0] = 0.5  # a spring that is at rest where the model starts
    engine_model.model.qpos_spring[0] = 1.0
    with pytest.raises(ValueError, match="misreads this model: MuJoCo accelerates joint"):
        judge(Model(problem, engine_model), 0.2, quick=True)


@pytest.mark.slow(beside="test_a_rebuilt_model_is_caught")
def test_an_own_setting_may_be_that_of_a_problem_alone() -> None:
    arm = galvi.from_mujoco(hinge(0.5), key=0)
    judgement = judge(arm, 1.0, quick=True)
    assert judgement.own["error"] == pytest.approx(4.39e-5, rel=2e-3)
    assert any("was made from the problem" in note for note in judgement.notes)
