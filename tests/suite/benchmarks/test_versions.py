"""Releases of an engine on a user's own run: changes are found between the right releases, and
rounding is no change."""

from __future__ import annotations

from pathlib import Path

import pytest

import galvi
from benchmarks.applications.releases import requirements, versions
from benchmarks.applications.releases.own_run import OwnRun, read_own_run
from benchmarks.applications.releases.requirements import (
    by_age,
    installed,
    listed,
    requested_releases,
)
from benchmarks.applications.releases.requirements import requirement as required
from benchmarks.applications.releases.versions import Versions, compare_releases
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from galvi.interop.judge import JudgeRequest
from references.mujoco.body import mujoco_body
from reports.tables.versions import changes, rows, sentences
from tests.suite.benchmarks.planted_releases import (
    ACCELERATIONS,
    BLOWS_UP,
    ENERGY,
    EULER,
    EULER_AT_OTHER_STEPS,
    FAILS,
    GRAVITY,
    ROUNDS_EACH_STEP,
    ROUNDS_MODEL,
    ROUNDS_PLANETS,
    SAME,
    SHORT,
    STEP,
    planted,
)

mujoco, rebound = pytest.importorskip("mujoco"), pytest.importorskip("rebound")
BODY = (
    mujoco_body(galvi.problems.free_rigid_body().system)
    .mjcf()
    .replace("<option ", '<option integrator="RK4" timestep="0.0125" ')
)
SPIN = (2.0, -1.9, 1.0)
PENDULUM = """<mujoco><option timestep="0.005" integrator="RK4"/><worldbody>
<body><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" contype="0"/>
<body pos="0 0 -.5"><joint axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" contype="0"/></body></body>
</worldbody></mujoco>"""
BOXES = """<mujoco><option timestep="0.005"/><worldbody><geom type="plane" size="5 5 .1"/>
<body pos="0 0 .4"><freejoint/><geom type="box" size=".1 .15 .2"/></body>
<body pos=".05 .02 .9"><freejoint/><geom type="capsule" size=".1 .15"/></body>
</worldbody></mujoco>"""


STIFF = """<mujoco><option timestep="0.05"/><worldbody><body><joint stiffness="1e6"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" contype="0"/></body></worldbody></mujoco>"""


def run_of_model(folder: Path, text: str, **fields) -> OwnRun:
    file = folder / "model.xml"
    file.write_text(text)
    return read_own_run(file, JudgeRequest(**fields))


def run_of_planets(
    folder: Path, duration: float, eccentricity: float = 0.05, **integrator_settings
) -> OwnRun:
    """A star, two planets and a test particle."""
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=eccentricity)
    sim.add(m=3e-4, a=1.9, e=0.05, f=2.0)
    sim.add(m=1e-9, a=4.0, f=1.0)
    sim.N_active = 3
    sim.move_to_com()
    sim.integrator, sim.dt = "whfast", 0.1
    sim.save_to_file(str(folder / "planets.bin"), delete_file=True)
    return read_own_run(
        folder / "planets.bin", JudgeRequest(duration=duration, own=integrator_settings)
    )


def compared(monkeypatch, folder: Path, run: OwnRun, faults, halved: bool = False) -> Versions:
    monkeypatch.setattr(versions, "interpreter", planted(folder, faults))
    ends = [*faults][:: len(faults) - 1] if halved else [*faults]
    return compare_releases(run, ends, halved, folder)


def body(folder: Path) -> OwnRun:
    return run_of_model(folder, BODY, duration=2.0, qvel=SPIN)


def planets(folder: Path) -> OwnRun:
    return run_of_planets(folder, 20.0)


@pytest.mark.parametrize(
    ("run_in", "fault", "changed"),
    [
        (body, EULER, {"order", "positions", "velocities", "energy"}),
        (body, ACCELERATIONS, {"accelerations"}),
        (body, ENERGY, {"energy"}),
        (planets, GRAVITY, {"positions", "velocities", "energy", "accelerations"}),
        (planets, STEP, {"positions", "velocities"}),
    ],
    ids=["order", "accelerations", "energy", "G", "step"],
)
def test_a_planted_fault_is_a_change_of_what_it_touches_and_of_nothing_else(
    run_in, fault, changed, tmp_path, monkeypatch
):
    monkeypatch.setattr(versions, "truth_of", lambda run: (None, ""))
    comparison = compared(monkeypatch, tmp_path, run_in(tmp_path), {"3.0.0": fault, "3.1.0": SAME})
    assert {change["quantity"] for change in changes(comparison)} == changed
    assert {(change["earlier"], change["later"]) for change in changes(comparison)} == {
        ("3.0.0", "3.1.0")
    }
    first, last = (
        sentences(comparison),
        f"From 3.1.0 to {comparison.newest.version} nothing changed",
    )
    assert next(first).startswith("Between 3.0.0 and 3.1.0 ") and next(first).startswith(last)


def contacts(folder: Path) -> OwnRun:
    return run_of_model(folder, BOXES, duration=4.0)


def chaos(folder: Path) -> OwnRun:
    return run_of_model(folder, PENDULUM, duration=40.0, qpos=(2.0, 1.0))


def long_orbits(folder: Path) -> OwnRun:
    return run_of_planets(folder, 4000.0)


def adaptive(folder: Path) -> OwnRun:
    return run_of_planets(folder, 100.0, 0.9, integrator="ias15")


@pytest.mark.parametrize("run_in", [body, contacts, chaos, planets, long_orbits, adaptive])
def test_the_same_release_and_one_that_rounds_otherwise_have_changed_nothing(
    run_in, tmp_path, monkeypatch
):
    monkeypatch.setattr(versions, "truth_of", lambda run: (None, ""))
    run = run_in(tmp_path)
    rounds = ROUNDS_MODEL if run.package == "mujoco" else ROUNDS_PLANETS
    comparison = compared(monkeypatch, tmp_path, run, {"3.0.0": rounds, "3.1.0": SAME})
    assert changes(comparison) == []
    first, second = (step.differences for step in comparison.steps)
    assert any(difference.size > 0.0 for difference in first)  # it does round otherwise
    assert all(difference.size == 0.0 for difference in second)
    expected = f"From 3.0.0 to {comparison.newest.version} nothing changed by more than rounding."
    assert next(sentences(comparison)) == expected


def test_halving_names_neighbours_and_passes_by_releases_that_fail(tmp_path, monkeypatch):
    monkeypatch.setattr(versions, "truth_of", lambda run: (None, ""))
    faults = {f"3.{k}.0": SAME if k >= 11 else ENERGY for k in range(1, 17)}
    faults |= {"3.9.0": FAILS, "3.13.0": FAILS}
    monkeypatch.setattr(versions, "listed", lambda package: ["2.0.0", *faults, "4.0.0"])
    comparison = compared(monkeypatch, tmp_path, body(tmp_path), faults, halved=True)
    (change,) = changes(comparison)
    assert (change["earlier"], change["later"]) == ("3.10.0", "3.11.0")
    assert len(comparison.behaviours) <= 9 and "4.0.0" not in comparison.behaviours
    missing = [behaviour for behaviour in comparison.behaviours.values() if behaviour.missing]
    assert missing and all("unrecognized attribute" in behaviour.missing for behaviour in missing)
    table = rows(comparison).set_index("release")
    assert table["status"].astype(bool).sum() == len(missing)
    assert table.loc["mujoco 3.11.0", "energy_change"] < 1e-12


def test_a_release_that_cannot_be_had_is_a_row_with_its_reason_and_one_alone_is_refused(
    tmp_path, monkeypatch
):
    run = run_of_model(tmp_path, BODY, duration=2.0, qvel=SPIN)
    newest = installed("mujoco")
    comparison = compared(monkeypatch, tmp_path, run, {"3.0.0": SAME})
    assert comparison.truth is not None and comparison.truth.disagreement < 1e-7
    errors = [comparison.error(behaviour) for behaviour in comparison.behaviours.values()]
    assert errors[0] == errors[1] == pytest.approx(errors[0]) and 0.0 < errors[0] < 1e-6
    with pytest.raises(ValueError, match="name a release besides the installed one"):
        compare_releases(run, [newest], False, tmp_path)
    monkeypatch.setattr(versions, "interpreter", planted(tmp_path, {"3.0.0": FAILS}))
    with pytest.raises(ValueError, match=r"3\.0\.0: .*XML Error.*; 3\.1\.0: No matching"):
        compare_releases(run, ["3.0.0", "3.1.0", newest], False, tmp_path)


def test_where_a_run_begins_or_ceases_to_diverge_is_a_change(tmp_path, monkeypatch):
    faults = {"3.0.0": SAME, "3.1.0": BLOWS_UP, "3.2.0": BLOWS_UP, "3.3.0": FAILS}
    comparison = compared(monkeypatch, tmp_path, planets(tmp_path), faults)
    assert [step.changed for step in comparison.steps] == [True, False, True]
    assert [*comparison.behaviours.values()][3].missing
    reason, newest = "its states are not finite.", comparison.newest.version
    texts = [*sentences(comparison)]
    assert texts[:3] == [
        f"Between 3.0.0 and 3.1.0 your run began to fail: {reason}",
        f"From 3.1.0 to 3.2.0 your run fails: {reason}",
        f"Between 3.2.0 and {newest} your run ceased to fail: {reason}",
    ]
    assert "To find the release: --releases 3.0.0..3.1.0." in texts
    assert [change["quantity"] for change in changes(comparison)] == ["failure", "failure"]


def test_a_model_that_diverges_since_the_installed_release_is_compared(tmp_path, monkeypatch):
    run = run_of_model(tmp_path, STIFF, duration=1.0, qpos=(1.0,))
    comparison = compared(monkeypatch, tmp_path, run, {"3.0.0": SHORT, "3.1.0": SHORT})
    assert [step.changed for step in comparison.steps] == [False, True]
    assert "BADQACC" in comparison.newest.failure
    assert f"and {comparison.newest.version} your run began to fail" in [*sentences(comparison)][1]


@pytest.mark.parametrize(
    ("duration", "integrator_settings"),
    [(4000.0, {}), (5000.0, {"integrator": "ias15"})],
    ids=["fixed", "chosen"],
)
def test_rounding_in_each_step_of_a_long_run_is_no_change(
    duration, integrator_settings, tmp_path, monkeypatch
):
    monkeypatch.setattr(versions, "truth_of", lambda run: (None, ""))
    run = run_of_planets(tmp_path, duration, **integrator_settings)
    comparison = compared(monkeypatch, tmp_path, run, {"3.0.0": ROUNDS_EACH_STEP})
    (step,) = comparison.steps
    assert not step.changed
    motion = comparison.newest.motion
    assert motion is not None and motion.steps_taken > 1e4
    # It does round otherwise.
    assert max(difference.floors for difference in step.differences) > 1.0


def test_an_order_alone_is_no_change_of_a_run(tmp_path, monkeypatch):
    monkeypatch.setattr(versions, "truth_of", lambda run: (None, ""))
    comparison = compared(monkeypatch, tmp_path, body(tmp_path), {"3.0.0": EULER_AT_OTHER_STEPS})
    (step,) = comparison.steps
    assert step.order_changed and not step.changed and changes(comparison) == []


def test_without_a_truth_a_sentence_says_why(tmp_path, monkeypatch):
    chaotic = run_of_model(tmp_path, PENDULUM, duration=60.0, qpos=(2.0, 1.0))
    for run, phrase in ((contacts(tmp_path), "contacts"), (chaotic, "part by")):
        truth, reason = versions.truth_of(run)
        assert truth is None and reason.startswith("There is no truth") and phrase in reason


def test_a_run_keeps_what_of_a_simulation_changes_it(tmp_path):
    run = run_of_planets(tmp_path, 10.0, coordinates="whds", dt=-0.05)
    assert run.job["settings"] == {"N_active": 3} and run.job["options"] == {"coordinates": "whds"}
    assert run.job["particles"][3][0] == 1e-9 and run.duration == -10.0
    sim = rebound.Simulation(str(tmp_path / "planets.bin"))
    sim.integrator.coordinates, sim.dt = "whds", -0.05
    sim.steps(200)
    sim.synchronize()
    motion = run.answer([run.request()]).motions[0]
    assert motion.positions[-1].tolist() == [x for p in sim.particles for x in p.xyz]
    sim.gravity = "tree"
    sim.root_size = 100.0
    sim.save_to_file(str(tmp_path / "tree.bin"))
    with pytest.raises(ValueError, match="gravity by a tree"):
        read_own_run(tmp_path / "tree.bin", JudgeRequest())


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"own": {"integrator": "rk5"}}, "own integrator must be one of euler, .*'rk5'"),
        ({"own": {"epsilon": 1e-9}}, "options of your run must be among .*'epsilon'"),
        ({"own": {"dt": 0}}, "the step must not be 0"),
        ({"own": {"dt": -0.1}}, "must be positive"),
        ({"duration": -1.0}, "goes forwards in time"),
        ({"snapshot": 3}, "for REBOUND files"),
    ],
)
def test_a_run_that_cannot_be_asked_for_is_refused(fields, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        run_of_model(tmp_path, BODY, **fields)


def test_files_of_one_release_and_runs_in_which_nothing_moves_are_refused(tmp_path):
    run = run_of_model(tmp_path, PENDULUM)
    with pytest.raises(ValueError, match="nothing moves in your run"):
        compare_releases(run, ["3.17.0"], False, tmp_path)
    mujoco.mj_saveModel(mujoco.MjModel.from_xml_string(BODY), str(tmp_path / "body.mjb"), None)
    compiled = read_own_run(tmp_path / "body.mjb", JudgeRequest(qvel=SPIN))
    with pytest.raises(ValueError, match=r"cannot read body\.mjb"):
        compare_releases(compiled, ["3.17.0"], False, tmp_path)


def test_releases_are_read_and_ordered_by_age_and_others_refused(monkeypatch):
    assert requested_releases("mujoco", ["4.0.1", "3.6.0", "3.10.0"]) == (
        ["3.6.0", "3.10.0", "4.0.1"],
        False,
    )
    assert requested_releases("rebound", ["5.2.0 .. 4.0.0"]) == (["4.0.0", "5.2.0"], True)
    assert requested_releases("rebound", []) == ([*requirements.USUAL_RELEASES["rebound"]], False)
    for wrong in (["newest"], ["3.6.0.."], ["1.0..2.0..3.0"], ["--upgrade"], ["4"]):
        with pytest.raises(ValueError, match="--releases expects"):
            requested_releases("mujoco", wrong)
    assert required("mujoco", "4.0.1") == "mujoco-core==4.0.1"
    assert required("mujoco", "3.17.0") == "mujoco==3.17.0"
    assert sorted(["3.10.0", "3.6.0", "2.3.1.post1", "2.3.1"], key=by_age)[0] == "2.3.1"
    printed = {"mujoco": "Available versions: 3.10.0, 3.6.0, 3.6.0rc1", "mujoco-core": "none"}
    monkeypatch.setattr(requirements, "output_of", lambda command: printed[command[-1]])
    with pytest.raises(EnvironmentUnavailable, match="no releases of mujoco-core"):
        listed("mujoco")
    printed["mujoco-core"] = "mujoco-core (4.0.1)\nAvailable versions: 4.0.1, 4.0.0\n"
    assert listed("mujoco") == ["3.6.0", "3.10.0", "4.0.0", "4.0.1"]


def of_real_releases(run: OwnRun, names: list[str], folder: Path) -> Versions:
    """The comparison of real releases; skips the test where one cannot be installed."""
    try:
        comparison = compare_releases(run, names, False, folder)
    except ValueError as error:
        pytest.skip(str(error))
    failures = [
        behaviour.missing for behaviour in comparison.behaviours.values() if behaviour.missing
    ]
    if failures:
        pytest.skip("; ".join(failures))
    assert not list(folder.rglob("pyvenv.cfg"))
    return comparison


@pytest.mark.slow(beside="test_a_planted_fault_is_a_change_of_what_it_touches_and_of_nothing_else")
def test_rk4_went_from_order_2_to_4_between_3_17_and_4(tmp_path):
    run = run_of_model(tmp_path, BODY, duration=10.0, qvel=SPIN)
    comparison = of_real_releases(run, ["3.13.0", "3.17.0"], tmp_path)
    first, second = comparison.steps
    assert not first.changed and second.order_changed
    before, after = comparison.behaviours["3.17.0"], comparison.newest
    assert before.order == pytest.approx(2.0, abs=0.01)
    assert after.order == pytest.approx(4.0, abs=0.01)
    assert comparison.error(before) > 1e4 * comparison.error(after)  # 5.95e-5 and 1.4e-9
    assert {change["quantity"] for change in changes(comparison)} == {"order", "positions"}


@pytest.mark.slow(beside="test_a_planted_fault_is_a_change_of_what_it_touches_and_of_nothing_else")
def test_ias15_chooses_other_steps_from_rebound_4_0_3_on_and_whfast_is_the_same(tmp_path):
    names = ["4.0.2", "4.0.3", "4.6.0"]
    run = run_of_planets(tmp_path, 20.0, 0.95, integrator="ias15", epsilon=0.01)
    comparison = of_real_releases(run, names, tmp_path)
    assert [step.changed for step in comparison.steps] == [True, False, False]
    assert {change["quantity"] for change in changes(comparison)} == {
        "positions",
        "velocities",
        "energy",
    }
    whfast = of_real_releases(run_of_planets(tmp_path, 100.0), names, tmp_path)
    assert changes(whfast) == []
