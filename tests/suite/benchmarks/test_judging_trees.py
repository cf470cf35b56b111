"""Judging a tree of rigid bodies: errors of its joints, of one against its closed form."""

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


def swing(damping: float = 0.0, **own: object) -> Problem:
    """A ball of 1 kg at 1 m from a hinge, which swings from 2 radians; its moment is 1.01."""
    hinge = galvi.Joint("hinge", axis=(0.0, 1.0, 0.0), damping=damping)
    rod = galvi.Link(hinge, mass=1.0, centre=(0.0, 0.0, -1.0), inertia=(0.01,) * 3, name="rod")
    system = galvi.Multibody([rod])
    q, v = system.from_mujoco([2.0], [0.0])
    return Problem(system, q, v, parameters={"integrator": "RK4", "dt": 0.02, **own})


@pytest.fixture(scope="module")
def found() -> Judgement:
    return judge(swing(), duration=10.0, error=1e-6)


def test_the_error_of_a_pendulum_is_that_against_the_closed_form(found: Judgement) -> None:
    plain = galvi.Problem(galvi.Canonical(1.01, galvi.CosinePotential(9.81)), [2.0], [0.0])
    exact = PENDULUM.run(plain, found.duration, {"samples": 100})
    mine = trees.INTEGRATORS["rk4"].run(swing(), 10.0, {"step": 0.02, "save_every": 5})
    off = np.abs(mine.q - exact.q).max()
    assert found.own["error"] == pytest.approx(off, rel=1e-4)
    assert found.truth_agreement < 1e-9 and found.own["energy"] > 0.0
    assert list(found.parts["joint"]) == ["hinge of rod"]
    assert found.recommended is not None and found.recommended["error"] <= 1e-6
    tried = found.table["integrator"].drop_duplicates().tolist()
    assert {"MuJoCo RK4 (yours)", "MuJoCo Euler", "galvi degree 8, Gauss 8"} <= {*tried}
    assert "MuJoCo RK4" not in tried  # the same model with the same options
    assert len(found.encounters.columns) == 0


def test_where_sources_part_nothing_is_judged(found: Judgement) -> None:
    """Planted: a source that leaves the truth after 4 s."""
    assert math.isinf(found.trusted_until) and "part" not in sentences(found)[1]
    one = found.agreements[0]
    parted = replace(one, distances=np.where(one.t > 4.0, 0.1, one.distances))
    wrong = replace(found, agreements=(parted, *found.agreements[1:]))
    assert wrong.trusted_until == 4.0
    assert "After t = 4 the sources part, and nothing can be judged" in sentences(wrong)[1]
    opinion = replace(parted, source=found.agreements[-1].source)
    assert math.isinf(replace(found, agreements=(opinion,)).trusted_until)


def test_the_page_says_where_all_sources_are_of_one_engine(found: Judgement) -> None:
    assert "runs of galvi are never the truth" in sentences(found)[1]
    alone = "rests on one engine, MuJoCo: install the extra trees (pip install pin) for Pinocchio"
    assert (alone in sentences(found)[1]) is bool(PINOCCHIO_ACCELERATIONS.missing)
    first, *others = found.agreements
    second = replace(first, source=replace(first.source, label="another", engine="Pinocchio"))
    assert alone not in sentences(replace(found, agreements=(second, *others)))[1]


@pytest.mark.slow(beside="test_a_damped_hinge_is_judged_with_the_damping_of_its_integrator")
def test_a_damped_tree_has_no_energy_error() -> None:
    found = judge(swing(damping=0.1), duration=5.0, own={"integrator": "implicitfast"})
    assert math.isnan(found.own["energy"]) and math.isnan(found.own["momentum"])
    assert found.own["integrator"] == "MuJoCo implicitfast, dt = 0.02" and found.passed


def test_errors_of_balls_and_free_bodies_are_angles_and_lengths() -> None:
    links = [
        galvi.Link(galvi.Joint(kind), mass=1.0, inertia=(1.0, 2.0, 2.5))
        for kind in ("ball", "free")
    ]
    system = galvi.Multibody(links)
    half = 0.15  # of an angle of 0.3 about x
    one, other = np.zeros((2, 11))
    one[[0, 7]] = 1.0
    other[:2] = math.cos(half), math.sin(half)
    other[4:7], other[7] = (0.0, 0.4, 0.0), -1.0  # the same attitude
    runs = []
    for qpos in (one, other):
        q, v = system.from_mujoco(qpos, np.zeros(9))
        runs.append(galvi.Trajectory(Problem(system, q, v), np.zeros(1), q[None], v[None]))
    assert trees.errors(*runs)[0] == pytest.approx([0.3, 0.4], rel=1e-12)
    assert trees.names(runs[0].problem) == ["ball of link 0", "free of link 1"]


def test_a_start_at_which_nothing_moves_is_refused() -> None:
    still = swing().with_initial_state(*swing().system.from_mujoco([0.0], [0.0]))
    with pytest.raises(ValueError, match=r"nothing moves from this start: .*--key 0"):
        judge(still)


FLOATING = (ROOT / "docs" / "models" / "floating_arm.xml").read_text()


@pytest.mark.parametrize(
    ("start", "warned"),
    [({}, 1), ({"key": 0}, 0), ({"qvel": [0.0] * 9}, 1), ({"qvel": [0.0] * 8 + [0.1]}, 0)],
)
def test_a_floating_model_that_only_falls_is_told(start: dict[str, Any], warned: int) -> None:
    text = FLOATING.replace('gravity="0 0 0"', "")
    problem, _ = from_mujoco.read(text, (), start.get("key"), None, start.get("qvel"))
    truth = trees.INTEGRATORS["rk4"].run(problem, 1.0, {"step": 0.001, "save_every": 100})
    own = own_setting(cast(Kind, trees), Model(problem), {})
    found = trees.notes(Model(problem), own, truth)
    assert len(found) == warned
    assert all("moves as one rigid body" in one and "--key" in one for one in found)


@pytest.mark.slow(
    beside="tests/suite/reports/test_judge.py::test_only_an_error_that_was_asked_for_is_a_failure_and_an_unconfirmed_truth_is_none"
)
def test_a_run_that_fails_is_told_and_has_no_error() -> None:
    stiff = swing(damping=1000.0)  # beyond the stability of RK4 with its steps
    found = judge(stiff, duration=1.0, error=1e-6)
    assert math.isnan(found.own["error"]) and "unstable" in found.own["status"]
    assert not found.passed and np.isfinite(found.parts["largest_error"]).all()


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
    own, problem = from_mujoco.read(MOTOR.format(*ACTING[name]), key=0)[::-1]
    model = Model(problem, own)
    mine = own_setting(cast(Kind, trees), model, {})
    found = [group[0].label for group in trees.candidates(model, 2.0, mine)]
    theirs = {contender.name for contender in trees.INTEGRATORS.values() if not contender.missing}
    assert theirs - {mine.name} <= {*found}


HINGE = """<mujoco><option timestep="0.002" integrator="{integrator}"/><worldbody><body>
<joint axis="0 1 0" damping="{damping}"/>
<inertial pos="0 0 -.1" mass=".1" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody>
<keyframe><key name="up" qpos="1"/></keyframe></mujoco>"""


def hinge(damping: float, integrator: str = "Euler") -> Any:
    return mujoco.MjModel.from_xml_string(HINGE.format(damping=damping, integrator=integrator))


def judged_model(
    model: Any, duration: float, error: float | None = None, **start: Any
) -> Judgement:
    problem, mine = from_mujoco.read(model, (), start.pop("key", 0), **start)
    return judge(Model(problem, mine), duration, error, quick=True)


@pytest.mark.slow_cases(but=["0.1-0.000291"])
@pytest.mark.parametrize(
    ("damping", "error"),
    [(0.01, 2.76e-3), (0.1, 2.91e-4), (0.5, 4.39e-5), (2.0, 4.30e-6), (3.0, 1.52e-6)],
)
def test_a_damped_hinge_is_judged_with_the_damping_of_its_integrator(
    damping: float, error: float
) -> None:
    """Right values: mj_step against SciPy's Radau at 1e-12, written by hand, over 1 s."""
    found = judged_model(hinge(damping), 1.0, 1e-4)
    assert found.own["error"] == pytest.approx(error, rel=2e-3)
    assert found.passed is bool(error <= 1e-4)


def test_a_rebuilt_model_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the run of a model that was built from the problem, without implicit damping."""
    monkeypatch.setattr(trees, "own_contender", lambda model, name: trees.INTEGRATORS[name])
    whole = body.document
    monkeypatch.setattr(
        body, "document", lambda gravity, links, off: whole(gravity, links, (*off, "eulerdamp"))
    )
    found = judged_model(hinge(0.5), 1.0, 1e-4)
    with pytest.raises(AssertionError):
        assert found.own["error"] == pytest.approx(4.39e-5, rel=2e-3)


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
    problem, mine = from_mujoco.read(model, (), 0)
    own = own_setting(trees, Model(problem, mine), {})
    run = own.contender.run(problem, 12 * timestep, {"step": timestep, "save_every": 4})
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for row in range(1, 4):
        mujoco.mj_step(model, data, nstep=4)
        assert run.q[row, 0] == data.qpos[0]


def test_a_time_is_the_engines_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: a conversion of ours that takes a quarter of an hour, by the clock that is read."""
    late, real = 0.0, time.perf_counter

    def clock() -> float:
        return real() + late

    def slow(*given: Any, **more: Any) -> Any:
        nonlocal late
        late += 1000.0
        return converted(*given, **more)

    converted = as_trajectory.momentum_at
    monkeypatch.setattr(as_trajectory, "momentum_at", slow)
    monkeypatch.setattr("benchmarks.applications.judging.clock.time.perf_counter", clock)
    assert engine_clock.time.perf_counter is clock
    sim = pytest.importorskip("rebound").Simulation()
    for particle in ({"m": 1e-3, "x": 1.0, "vy": 1.0}, {"m": 1.0}):
        sim.add(**particle)
    sim.integrator, sim.dt = "whfast", 0.05
    points = Model(*read(sim, -1))
    for found in (judge(points, 5.0, quick=True), judged_model(hinge(0.1), 0.2)):
        assert late >= 1000.0 and found.own["seconds"] < 500.0
        engines = found.table[~found.table["integrator"].str.startswith("galvi")]
        assert (engines["seconds"].dropna() < 500.0).all()


def test_joints_have_their_names() -> None:
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body name="waist">
    <joint name="abdomen_y" axis="0 1 0"/><joint axis="1 0 0"/><joint axis="0 0 1"/>
    <inertial pos="0 0 -.1" mass=".1" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody></mujoco>""")
    problem, _ = from_mujoco.read(model, (), None, qpos=[0.5, 0.1, 0.0])
    names = ["abdomen_y", "hinge 2 of waist", "hinge 3 of waist"]
    assert trees.names(problem) == names == trees.entries(problem)


def test_a_start_may_be_given_in_the_engines_numbers() -> None:
    found = judged_model(hinge(0.0), 0.2, 1e-3, key=None, qpos=[0.7], qvel=[0.1])
    assert found.problem.q0 == pytest.approx([0.7]) and found.problem.v0 == pytest.approx([0.1])
    assert math.isfinite(found.own["error"])


def test_a_misread_model_is_refused_along_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: a reading that is right at the start only."""
    problem, mine = from_mujoco.read(hinge(0.0), (), 0)
    mine.model.jnt_stiffness[0] = 0.5  # a spring that is at rest where the model starts
    mine.model.qpos_spring[0] = 1.0
    with pytest.raises(ValueError, match="misreads this model: MuJoCo accelerates joint"):
        judge(Model(problem, mine), 0.2, quick=True)


@pytest.mark.slow(beside="test_a_rebuilt_model_is_caught")
def test_an_own_setting_may_be_that_of_a_problem_alone() -> None:
    arm = galvi.from_mujoco(hinge(0.5), key=0)
    alone = judge(arm, 1.0, quick=True)
    assert alone.own["error"] == pytest.approx(4.39e-5, rel=2e-3)
    assert any("was made from the problem" in note for note in alone.notes)
