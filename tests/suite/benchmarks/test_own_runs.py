"""The run that is judged is the user's: their engine on their own model, in the engine's time."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from benchmarks.applications.judging import bodies, trees
from benchmarks.applications.judging.candidate import Model
from benchmarks.applications.judging.judgement import Judgement, judge, own_setting
from galvi import Trajectory
from galvi.interop import from_mujoco
from galvi.interop.rebound import read
from references import as_trajectory, engine_clock
from reports.judge.sentences import sentences

rebound = pytest.importorskip("rebound")
mujoco = pytest.importorskip("mujoco")

# ---------------------------------------------------------------- simulations of REBOUND


def star_last() -> Any:
    """Two planets that were added before their star."""
    sim = rebound.Simulation()
    sim.add(m=1e-3, x=1.0, vy=1.0)
    sim.add(m=5e-4, x=-0.7, y=1.6, vx=-0.69, vy=-0.30)
    sim.add(m=1.0)
    sim.move_to_com()
    sim.integrator, sim.dt = "whfast", 0.05
    return sim


def judged(sim: Any, duration: float, error: float | None = None, **own: Any) -> Judgement:
    problem, mine = read(sim, -1)
    return judge(Model(problem, mine), duration, error, own, quick=True)


def off_by_hand(sim: Any, steps: int) -> float:
    """The largest distance of a particle from IAS15's after so many steps."""
    mine, truth = sim.copy(), sim.copy()
    truth.integrator = "ias15"
    mine.steps(steps)
    mine.synchronize()
    truth.integrate(steps * sim.dt + sim.t)
    return max(
        float(np.linalg.norm(np.subtract(a.xyz, b.xyz)))
        for a, b in zip(mine.particles, truth.particles, strict=True)
    )


@pytest.mark.slow(beside="test_an_own_run_is_the_engines_to_the_last_bit")
def test_particles_keep_their_order_and_a_ruined_run_is_not_called_good() -> None:
    sim = star_last()
    found = judged(sim, 100.0, 1e-3)
    assert found.own_errors["error"].iloc[-1] == pytest.approx(off_by_hand(sim, 2000), rel=1e-6)
    assert found.own["error"] > 100.0 and not found.passed
    assert any(
        "2, is particle 2, but REBOUND WHFast expects it first" in note for note in found.notes
    )
    assert found.recommended is not None  # candidates have the star first


@pytest.mark.slow(beside="test_an_own_run_is_the_engines_to_the_last_bit")
def test_a_sorted_simulation_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the run of a simulation that was built from the problem, the heaviest first."""
    monkeypatch.setattr(bodies, "own", lambda model, name: bodies.INTEGRATORS[name])
    sim = star_last()
    found = judged(sim, 10.0)
    with pytest.raises(AssertionError):
        assert found.own_errors["error"].iloc[-1] == pytest.approx(off_by_hand(sim, 200), rel=1e-2)


@pytest.mark.slow_cases(but=["janus"])
@pytest.mark.parametrize("integrator", ["whfast", "saba", "janus"])
def test_another_own_integrator_than_that_of_the_simulation(integrator: str) -> None:
    """WHFast leaves to BS the setting that its Kepler motion has the star's pull."""
    sim = star_last()
    sim.integrator = integrator
    found = judged(sim, 5.0, 1e-6, integrator="bs")
    assert found.own["status"].startswith("Completed.") and found.passed


def own_run(sim: Any, steps: int, every: int) -> Trajectory:
    problem, mine = read(sim, -1)
    own = own_setting(bodies, Model(problem, mine), {})
    assert own.step is not None
    return own.contender.run(
        problem, steps * own.step, {**own.options, "step": own.step, "save_every": every}
    )


@settings(max_examples=25, deadline=None)
@given(
    st.permutations(range(4)),
    st.sampled_from(["whfast", "saba", "leapfrog", "eos", "janus", "mercurius", "trace"]),
    st.sampled_from([-0.1, 0.05, 0.1]),
    st.integers(0, 3),
    st.booleans(),
)
def test_an_own_run_is_the_engines_to_the_last_bit(
    order: list[int], integrator: str, dt: float, done: int, massless: bool
) -> None:
    """Whatever the order of the particles, the direction of time, and what was done before."""
    sim = rebound.Simulation()
    made = rebound.Simulation()
    made.add(m=1.0)
    for m, a, e, f in ((1e-3, 1.0, 0.1, 0.3), (3e-4, 1.8, 0.05, 2.0), (1e-5, 3.1, 0.2, 4.0)):
        made.add(m=m, a=a, e=e, f=f)
    chosen = [*[k for k in order if k < 3], 3] if massless else order
    for k in chosen:
        sim.add(made.particles[k])
    if massless:
        sim.N_active = 3
    sim.integrator, sim.dt = integrator, dt
    if integrator == "whfast":
        sim.integrator.safe_mode, sim.integrator.corrector = 0, 11
    sim.steps(done)
    by_hand = sim.copy()
    run = own_run(sim, 12, 4)
    for row in range(1, 4):
        by_hand.steps(4)
        by_hand.synchronize()
        assert np.array_equal(run.q[row], [p.xyz for p in by_hand.particles])
    assert run.t[-1] == pytest.approx(sim.t + 12 * dt)


def backwards() -> Any:
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=5.2, e=0.05)
    sim.add(m=0.0, a=3.46, e=0.64, f=2.0)
    sim.move_to_com()
    sim.dt = -0.01
    return sim


@pytest.mark.slow_cases("ias15")
@pytest.mark.parametrize("integrator", ["ias15", "whfast"])
def test_a_run_backwards_is_judged_backwards(integrator: str) -> None:
    sim = backwards()
    sim.integrator, sim.dt = integrator, -0.01
    found = judged(sim, 20.0, 1e-6)
    assert found.duration == pytest.approx(-20.0)
    assert found.own_errors["t"].iloc[-1] == pytest.approx(-20.0)
    assert "backwards" in sentences(found)[0]
    assert all(one.t[-1] < 0.0 for one in found.agreements)
    assert found.recommended is not None and found.recommended["error"] <= 1e-6


@pytest.mark.slow(beside="test_a_run_backwards_is_judged_backwards")
def test_encounters_of_the_past_are_those_of_the_past() -> None:
    sim = backwards()
    past = judged(sim, 440.0, 1e-6).encounters
    gaps = []
    for t in np.linspace(0.0, -440.0, 44_001):
        sim.integrate(t)
        gaps.append(float(np.linalg.norm(np.subtract(sim.particles[2].xyz, sim.particles[1].xyz))))
    k = int(np.argmin(gaps))
    assert (past["time"] < 0.0).all()
    assert past["time"].iloc[0] == pytest.approx(-0.01 * k, abs=0.05)
    assert past["distance"].iloc[0] == pytest.approx(gaps[k], rel=0.05)


@pytest.mark.slow(
    beside="tests/properties/test_reading_rebound.py::test_a_tree_is_read_as_point_masses_and_says_so"
)
def test_a_tree_of_gravity_is_that_of_the_own_run_only() -> None:
    sim = rebound.Simulation()
    sim.root_size = 40.0
    sim.add(m=1.0)
    generator = np.random.default_rng(3)
    for a, f in zip(np.linspace(1.0, 4.0, 30), generator.uniform(0, 6.28, 30), strict=True):
        sim.add(m=1e-3, a=a, f=f)
    sim.gravity, sim.integrator, sim.dt = "tree", "leapfrog", 0.01
    direct = sim.copy()
    direct.gravity = "basic"
    found = judged(sim, 5.0)
    assert any("tree" in note for note in (*found.notes, str(found.problem.parameters["read_as"])))
    plain = judged(direct, 5.0)
    assert found.own["error"] != pytest.approx(plain.own["error"], rel=0.1)
    truth = direct.copy()
    truth.integrator = "ias15"
    truth.integrate(sim.t + 5.0)
    sim.steps(500)
    by_hand = np.linalg.norm(
        np.subtract([p.xyz for p in sim.particles], [p.xyz for p in truth.particles]), axis=1
    ).max()
    assert found.own_errors["error"].iloc[-1] == pytest.approx(by_hand, rel=1e-6)


def kepler_16() -> Any:
    sim = rebound.Simulation()
    sim.add(m=0.69, name="A")
    sim.add(m=0.2, a=0.224, e=0.16, name="B")
    sim.add(m=3e-4, a=0.705, name="b")
    sim.move_to_com()
    sim.integrator, sim.dt, sim.t = "whfast", 0.02, 2455212.12316
    return sim


@pytest.mark.slow(beside="test_judging.py::test_moons_are_no_encounters_and_set_the_pace")
def test_a_companion_star_has_no_encounters_and_dates_keep_their_digits() -> None:
    found = judged(kepler_16(), 60.0, 1e-12)
    assert len(found.encounters) == 0
    assert not any("encounter" in sentence for sentence in sentences(found))
    problem, mine = read(kepler_16(), -1)
    whole = judge(Model(problem, mine), 60.0, 1e-8)
    for sentence in sentences(whole):
        assert "e+06" not in sentence
    assert any("24552" in sentence for sentence in sentences(whole))


@pytest.mark.slow(beside="test_a_rebuilt_model_is_caught")
def test_what_does_not_agree_is_not_said_to() -> None:
    """galvi's opinion, of eight steps a revolution, is off by hundreds at e = 0.99."""
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=3e-6, e=0.99, a=1.0)
    found = judged(sim, 60.0, 1e-6)
    opinion = next(one for one in found.agreements if one.source.opinion)
    truth = _of_truth(found)
    claim, agreed = truth.split("It agrees with ", 1)
    assert opinion.largest > 1.0 and agreed.startswith("REBOUND") and "galvi" not in agreed
    assert claim.endswith("runs of galvi are never the truth. ")
    stopped = next(one for one in found.agreements if one.source.engine == "SciPy")
    assert not stopped.stopped or "up to t = " in truth
    apart = replace(found.agreements[0], apart=np.full_like(found.agreements[0].apart, 8.5e-4))
    parted = replace(found, agreements=(apart,), error=1e-6)
    assert "REBOUND IAS15 differs from it by up to 8.50·10⁻⁴" in _of_truth(
        parted
    ) and "Smaller errors cannot be measured" in _of_truth(parted)
    assert not any("Nothing that was tried" in one for one in sentences(parted))


def _of_truth(found: Judgement) -> str:
    return next(one for one in sentences(found) if one.startswith("The truth is"))


def test_labels_name_what_is_not_usual() -> None:
    sim = star_last()
    sim.integrator.coordinates, sim.integrator.corrector = "democraticheliocentric", 0
    problem, mine = read(sim, -1)
    label = own_setting(bodies, Model(problem, mine), {}).label.lower()
    assert "coordinates democraticheliocentric" in label and "dt = 0.05" in label
    sim.integrator.coordinates, sim.integrator.corrector, sim.integrator.kernel = (
        "jacobi",
        17,
        "LAZY",
    )
    problem, mine = read(sim, -1)
    label = own_setting(bodies, Model(problem, mine), {}).label
    assert "corrector 17" in label and "kernel lazy" in label


@pytest.mark.slow(beside="test_a_run_backwards_is_judged_backwards")
def test_a_distance_at_which_the_users_run_ends_is_named() -> None:
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0)
    sim.add(m=0.0, x=10.0, vx=2.0)
    sim.N_active, sim.integrator, sim.dt, sim.exit_max_distance = 2, "whfast", 0.05, 50.0
    (note,) = [one for one in judged(sim, 40.0, 1e-3).notes if "exit_max_distance" in one]
    assert "exit_max_distance = 50 is ignored here: your own run ends there at about t = 2" in note
    sim.exit_max_distance = 1e3
    assert any("never reaches it" in note for note in judged(sim, 40.0, 1e-3).notes)


def test_an_integrator_that_cannot_be_judged_says_what_to_do() -> None:
    sim = star_last()
    sim.integrator = "none"
    with pytest.raises(ValueError, match=r"model's own integrator .* --own integrator=ias15"):
        judged(sim, 10.0)


@pytest.mark.slow(beside="test_another_own_integrator_than_that_of_the_simulation")
def test_where_a_truth_takes_long_something_is_said_first(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, mine = read(star_last(), -1)
    said: list[str] = []
    judge(Model(problem, mine), 100.0, 1e-3, report=said.append, quick=True)
    assert not any("First answer" in one for one in said)
    monkeypatch.setattr("benchmarks.applications.judging.judgement.AWAITED", 0.0)
    said.clear()
    judge(Model(problem, mine), 100.0, 1e-3, report=said.append, quick=True)
    first = next(k for k, one in enumerate(said) if one.startswith("First answer: after 2 of 100 "))
    assert first < next(k for k, one in enumerate(said) if one.startswith("truth: "))


# ---------------------------------------------------------------- models of MuJoCo

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
    from references.mujoco import body

    monkeypatch.setattr(trees, "own", lambda model, name: trees.INTEGRATORS[name])
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
    sim = star_last()
    for found in (judged(sim, 5.0), judged_model(hinge(0.1), 0.2)):
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


@pytest.mark.slow(beside="test_another_own_integrator_than_that_of_the_simulation")
def test_an_own_setting_may_be_that_of_a_problem_alone() -> None:
    problem, _ = read(star_last(), -1)
    found = judge(problem, 100.0, 1e-3, quick=True)
    assert found.own["error"] > 100.0
    arm = galvi.from_mujoco(hinge(0.5), key=0)
    alone = judge(arm, 1.0, quick=True)
    assert alone.own["error"] == pytest.approx(4.39e-5, rel=2e-3)
    assert any("was made from the problem" in note for note in alone.notes)
