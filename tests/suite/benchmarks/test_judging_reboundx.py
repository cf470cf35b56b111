"""Judging simulations with REBOUNDx's forces: all of REBOUND's runs have them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.applications.judging import bodies
from benchmarks.applications.judging.candidate import Model
from benchmarks.applications.judging.judgement import Judgement, judge
from galvi.interop.rebound import check_reading, read
from reports.judge.sentences import sentences

rebound = pytest.importorskip("rebound")
reboundx = pytest.importorskip("reboundx", reason="REBOUNDx is an extra")

C = 10065.32  # in au and years / 2 pi


def planets(force: str = "gr_potential", c: float = C, **overrides: Any) -> tuple[Any, Any]:
    """A star and two planets, and the extras with a force."""
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.add(m=1e-3, a=1.7, f=2.0)
    sim.move_to_com()
    for name, value in {"integrator": "whfast", "dt": 0.05, **overrides}.items():
        setattr(sim, name, value)
    rebx = reboundx.Extras(sim)
    loaded_force = rebx.load_force(force)
    rebx.add_force(loaded_force)
    loaded_force.params["c"] = c
    return sim, rebx


def save_files(sim: Any, rebx: Any, folder: Path) -> tuple[str, str]:
    files = str(folder / "planets.bin"), str(folder / "rebx.bin")
    sim.save_to_file(files[0])
    rebx.save(files[1])
    return files


def judged(
    sim: Any, rebx: Any, folder: Path, duration: float, error: float, **integrator_settings: Any
) -> Judgement:
    file, extras = save_files(sim, rebx, folder)
    problem, engine_sim = read(file, -1, extras)
    return judge(Model(problem, engine_sim), duration, error, integrator_settings, quick=True)


def positions_by_rebound(sim_and_extras: Any, integrator: str, t: float) -> np.ndarray:
    """Positions of the particles at t, a multiple of the step, by REBOUND and REBOUNDx alone."""
    sim, _ = sim_and_extras
    sim.integrator, sim.exact_finish_time = integrator, int(integrator == "ias15")
    if integrator == "ias15":
        sim.integrate(t)
    else:
        sim.steps(round(t / sim.dt))
        sim.synchronize()
    return np.array([p.xyz for p in sim.particles])


def test_the_own_error_is_that_of_an_independent_run() -> None:
    """With a force so strong that a run without it errs by more than a thousand times as much."""
    sim, rebx = planets(c=100.0)
    judgement = galvi.judge(sim, duration=50.0, error=1e-5, extras=rebx, quick=True)
    runs = [
        positions_by_rebound(planets(c=100.0), integrator, 50.0)
        for integrator in ("whfast", "ias15")
    ]
    whfast_error = float(np.linalg.norm(runs[0] - runs[1], axis=1).max())
    assert judgement.own["last_error"] == pytest.approx(whfast_error, rel=1e-2)
    plain = planets(c=1e9)
    assert np.abs(positions_by_rebound(plain, "ias15", 50.0) - runs[1]).max() > 1e3 * whfast_error
    assert judgement.passed and judgement.truth_agreement < 1e-11
    assert "SciPy DOP853" in " ".join(judgement.summary)  # another engine, with the force as read
    reached = judgement.table[judgement.table["reached"]]["integrator"]
    for name in ("galvi degree 8", "REBOUND IAS15", "REBOUND BS", "REBOUND WHFast", "REBOUND SABA"):
        assert reached.str.startswith(name).any(), name
    assert not judgement.table["integrator"].str.contains("512").any()
    assert len(sim.particles) == 3 and sim.t == 0.0  # the user's simulation is unchanged


def test_the_truth_is_right_as_its_own_run() -> None:
    sim, rebx = planets(integrator="ias15")
    judgement = galvi.judge(sim, duration=50.0, error=1e-9, extras=rebx, quick=True)
    assert judgement.own["error"] < 1e-12 and judgement.passed  # 1e-13


def test_runs_without_the_force_are_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: REBOUND runs the simulation without its forces."""
    of_user = bodies.of_user

    def wrong(contender: Any, sim: Any, problem: Any, **options: Any) -> Any:
        wrapped = of_user(contender, sim.simulation, problem, **options)
        return type(wrapped)(**{**vars(wrapped), "fits": lambda problem: True})

    monkeypatch.setattr(bodies, "of_user", wrong)
    judgement = judged(*planets(c=100.0), tmp_path, 20.0, 1e-6)
    assert judgement.truth_agreement > 1e-5  # with SciPy's run, which has them


def test_a_reading_that_is_wrong_is_caught_at_other_states(tmp_path: Path) -> None:
    file, extras = save_files(*planets(c=100.0), tmp_path)
    problem, engine_sim = read(file, -1, extras)
    displaced = problem.q0 + np.random.default_rng(1).normal(size=problem.q0.shape)
    check_reading(engine_sim, problem, displaced, problem.v0)
    system = galvi.NBody(problem.system.masses, 1.0, galvi.Relativity(101.0, 0, "potential"))
    misread = galvi.Problem(system, problem.q0, problem.v0)
    with pytest.raises(ValueError, match="misreads REBOUNDx's gr_potential"):
        check_reading(engine_sim, misread, displaced, problem.v0)


def test_a_force_that_is_read_to_some_order_has_no_other_engine(tmp_path: Path) -> None:
    """REBOUNDx has gr in Jacobi coordinates, galvi as of one source."""
    judgement = judged(*planets("gr", 100.0), tmp_path, 10.0, 1e-3)
    assert judgement.engines == ("REBOUND",)
    assert "rests on one engine, REBOUND." in " ".join(sentences(judgement))
    assert any("Accelerations by gr as read by galvi differ" in note for note in judgement.notes)


def test_the_command_takes_a_file_of_extras(tmp_path: Path) -> None:
    file, extras = save_files(*planets(), tmp_path)

    def command(*options: str) -> subprocess.CompletedProcess[str]:
        arguments = [file, "--duration", "5", "--error", "1e-3", "--quick", "--out", str(tmp_path)]
        return subprocess.run(
            [sys.executable, "-m", "galvi", "judge", *arguments, *options],
            capture_output=True,
            text=True,
            check=False,
        )

    completed = command("--extras", extras)
    assert completed.returncode == 0, completed.stderr
    report = json.loads((tmp_path / "judge.json").read_text())
    assert report["passed"] and "functions" not in completed.stdout + completed.stderr
    bare = command()
    assert "forces among them are not in it" in bare.stdout
    for wrong, message in (
        (file, "must be a file of REBOUNDx's"),
        ("none.bin", "There is no file"),
    ):
        refused = command("--extras", wrong)
        assert refused.returncode == 2 and message in refused.stderr


def test_extras_are_refused_where_they_do_not_belong(tmp_path: Path) -> None:
    sim, rebx = planets()
    file, _ = save_files(sim, rebx, tmp_path)
    problem = galvi.from_rebound(sim, extras=rebx)
    for source in (file, problem, "<mujoco/>"):
        with pytest.raises(ValueError, match="extras belong to a"):
            galvi.judge(source, extras=rebx)
    with pytest.raises(TypeError, match=r"extras must be a reboundx\.Extras"):
        galvi.judge(sim, extras="rebx.bin")
    with pytest.raises(ValueError, match=r"galvi\.judge\(sim, extras=rebx\)"):
        galvi.judge(sim)
    sim.integrator = "whfast512"
    with pytest.raises(ValueError, match="no forces for whfast512"):
        galvi.judge(sim, duration=1.0, extras=rebx)
