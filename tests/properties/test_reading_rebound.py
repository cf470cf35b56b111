"""Simulations of REBOUND are read completely, or refused by the names of what is not supported."""

from __future__ import annotations

import ctypes
import logging
import pickle
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.interop import rebound as reader
from galvi.interop import rebound_contents as contents
from references.rebound.ias15 import IAS15

rebound = pytest.importorskip("rebound")

SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
NUMBERS = (ctypes.c_double, ctypes.c_int, ctypes.c_uint, ctypes.c_size_t, ctypes.c_long)


def simulation(active: bool = True) -> Any:
    """A star, a planet and an asteroid, which has a mass if it is not active, at t = 3 years."""
    sim = rebound.Simulation()
    sim.units = ("AU", "yr", "Msun")
    sim.add(m=1.0, name="Sun")
    sim.add(m=1e-3, a=1.0, e=0.1, inc=0.1, name="Planet")
    sim.add(m=0.0 if active else 1e-6, a=2.1, e=0.05)
    if not active:
        sim.N_active = 2
    sim.integrator = "whfast"
    sim.integrator.safe_mode, sim.integrator.keep_unsynchronized = 0, 1
    sim.dt = 0.01
    sim.steps(300)
    return sim


def planets(**fields: Any) -> Any:
    sim = rebound.Simulation()
    sim.add(m=1.0, name="Star")
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.add(m=3e-4, a=1.8, e=0.05, f=2.0)
    for name, value in fields.items():
        setattr(sim, name, value)
    return sim


# ---------------------------------------------------------------- in and out


@pytest.mark.parametrize("active", [True, False])
def test_a_simulation_comes_in_with_all_it_has_and_stays_as_it_was(active: bool) -> None:
    sim = simulation(active)
    before = sim.particles[1].x
    problem = galvi.from_rebound(sim)
    assert not sim.is_synchronized and sim.particles[1].x == before
    assert problem.t0 == sim.t and problem.system.G == sim.G
    assert problem.units == "length au, time yr, mass msun"
    assert problem.parameters["bodies"] == ("Sun", "Planet", "2")
    assert problem.parameters["integrator"] == "whfast" and problem.parameters["dt"] == 0.01
    assert problem.system.masses.tolist() == [1.0, 1e-3, 0.0]
    sim.synchronize()
    assert np.array_equal(problem.q0, [p.xyz for p in sim.particles])


@pytest.mark.parametrize("active", [True, False])
def test_the_run_of_a_simulation_goes_out_with_all_it_has(active: bool) -> None:
    sim = simulation(active)
    problem = galvi.from_rebound(sim)
    run = galvi.integrate(problem, EIGHT, 0.1, 100)
    truth = IAS15.run(problem, 10.0, {"samples": 1})
    assert np.max(np.abs(run.q[-1] - truth.q[-1])) < 1e-11
    exported = run.to_rebound()
    assert exported.units == sim.units and exported.G == sim.G and exported.t == run.t[-1]
    assert [p.name for p in exported.particles] == [
        "Sun",
        "Planet",
        None,
    ] and exported.N_active == 2
    assert exported.energy() == pytest.approx(galvi.energy(run)[-1], rel=1e-14)
    reimported = galvi.from_rebound(run.to_rebound(at=7))
    assert reimported.t0 == run.t[7] and np.array_equal(reimported.q0, run.q[7])
    assert np.array_equal(reimported.v0, run.v[7])


def test_what_a_simulation_has_comes_back(tmp_path: Any) -> None:
    sim = planets(integrator="whfast", dt=-0.07, exit_max_distance=50.0)
    sim.integrator.corrector, sim.integrator.kernel = 11, "LAZY"
    sim.particles[1].r = 4e-4
    problem = galvi.from_rebound(sim)
    assert problem.parameters["exit_max_distance"] == 50.0
    exported = galvi.integrate(problem, SIX, -0.1, 4).to_rebound(at=0)
    assert exported.integrator.name.decode() == "whfast" and exported.dt == -0.07
    assert exported.integrator.corrector == 11 and exported.integrator.kernel == "LAZY"
    assert [p.r for p in exported.particles] == [0.0, 4e-4, 0.0] and exported.particles[
        0
    ].name == "Star"
    assert galvi.from_rebound(exported).parameters == {
        key: value for key, value in problem.parameters.items() if key != "exit_max_distance"
    }


def test_the_usual_time_between_the_states_of_an_archive_is_read(tmp_path: Any) -> None:
    sim, file = planets(), tmp_path / "archive.bin"
    for k in range(5):
        sim.integrate(0.7 * k)
        sim.save_to_file(str(file))
    assert galvi.from_rebound(file).parameters["output_every"] == pytest.approx(0.7)
    assert galvi.from_rebound(str(file), snapshot=1).t0 == pytest.approx(0.7)
    for snapshot in ("x", 1.5, True, None):
        with pytest.raises(ValueError, match=r"snapshot must be a whole number; received .* -1 is"):
            galvi.from_rebound(file, snapshot=snapshot)
    with pytest.raises(ValueError, match="snapshot must be a whole number from -5 to 4"):
        galvi.from_rebound(file, snapshot=5)
    planets().save_to_file(str(file), delete_file=True)
    assert "output_every" not in galvi.from_rebound(file).parameters


@pytest.mark.slow(beside="test_the_usual_time_between_the_states_of_an_archive_is_read")
def test_a_broken_file_is_refused(tmp_path: Any) -> None:
    path, broken = tmp_path / "run.bin", tmp_path / "broken.bin"
    planets().save_to_file(str(path))
    archive = path.read_bytes()
    for content in (b"", b"no archive", archive[:100], archive[: len(archive) // 2]):
        broken.write_bytes(content)
        with pytest.raises(ValueError, match=r"broken\.bin must be a file of REBOUND's"):
            galvi.from_rebound(broken)
    with pytest.raises(FileNotFoundError, match="there is no file"):
        galvi.from_rebound(tmp_path / "absent.bin")


def test_a_file_is_read_in_another_process_which_may_crash(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, sim = tmp_path / "run.bin", simulation()
    sim.save_to_file(str(path))
    problem = galvi.from_rebound(path)
    monkeypatch.setattr(rebound, "Simulationarchive", None)  # here nothing is read
    assert problem.q0.tobytes() == galvi.from_rebound(path).q0.tobytes()
    assert pickle.loads(pickle.dumps(galvi.from_rebound(sim))).parameters == problem.parameters
    program, damaged = tmp_path / "program.py", "it is damaged: REBOUND crashes"
    monkeypatch.setattr(reader, "READER", str(program))
    for text, message in (
        ("import os; os.kill(os.getpid(), 11)", damaged),
        ("import os; os._exit(3)", damaged),
        ("import galvi_absent", "ended with: ModuleNotFoundError: No module named"),
    ):
        program.write_text(text)
        with pytest.raises(ValueError, match=message):
            galvi.from_rebound(path)


@pytest.mark.slow(beside="test_the_usual_time_between_the_states_of_an_archive_is_read")
def test_a_heartbeat_and_a_patch_version_do_not_matter(
    tmp_path: Any, caplog: pytest.LogCaptureFixture
) -> None:
    sim = planets(heartbeat=lambda pointer: None)
    sim.integrate(1.0)
    problem = galvi.from_rebound(sim)
    path = tmp_path / "run.bin"
    sim.save_to_file(str(path))
    with caplog.at_level(logging.WARNING, logger="galvi"):
        problem_of_file, loaded = reader.read(path)
    assert (
        np.array_equal(problem_of_file.q0, problem.q0) and loaded.N == 3 and not loaded._heartbeat
    )
    assert "forces among them are not in it" in problem_of_file.parameters["functions"]
    assert "forces among them are not in it" in caplog.text
    older = tmp_path / "older.bin"
    installed = rebound.__version__.encode()
    older.write_bytes(path.read_bytes().replace(installed, b"5.2.1"[: len(installed)], 1))
    older_problem = galvi.from_rebound(older)
    assert np.array_equal(older_problem.q0, problem.q0)
    assert "written by REBOUND 5.2.1" in older_problem.parameters["written_by"]
    for version in (b"4.4.9", b"3.9.3"):
        older.write_bytes(path.read_bytes().replace(installed, version, 1))
        with pytest.raises(ValueError, match=rf"by REBOUND {version.decode()}, .*Load it with"):
            galvi.from_rebound(older)


# ---------------------------------------------------------------- what is refused


def sheared(sim: Any) -> None:
    """The shearing sheet: at t = pi a body is at (0.7, -0.6 pi), and a point mass at (0.1, 0)."""
    sim.integrator, sim.OMEGA = "sei", 1.0


def relativistic(sim: Any) -> None:
    sim.integrator = "whfast512"
    sim.integrator.gr_potential = 1


def with_pulling_test_particles(sim: Any) -> None:
    sim.N_active, sim.testparticle_type, sim.particles[2].m = 2, 1, 1e-6


def forced(sim: Any, extras: int = 0) -> None:
    """With additional forces, which are REBOUNDx's where it has set ``extras``."""
    sim.additional_forces = lambda pointer: None
    sim.extras = extras


def with_nan_position(sim: Any) -> None:
    sim.particles[1].x = float("nan")


REFUSED = {
    r"OMEGA = 1\.0.*the integrator 'sei'": sheared,
    r"whfast512\.gr_potential = 1": relativistic,
    "test particles that pull": with_pulling_test_particles,
    "additional forces": forced,
    r"additional forces\. Give .*extras=rebx\)\.$": lambda sim: forced(sim, 1),
    r"extras=rebx\)\. Remove softening \(0\.1\) in REBOUND": lambda sim: (
        forced(sim, 1),
        setattr(sim, "softening", 0.1),
    ),
    "collisions": lambda sim: setattr(sim, "collision", "direct"),
    r"softening \(0\.1\)": lambda sim: setattr(sim, "softening", 0.1),
    "variational particles": lambda sim: sim.add_variation(),
    r"received the position \[nan, .* of particle 1": with_nan_position,
}


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("message", REFUSED)
def test_what_is_more_than_point_masses_is_refused_by_name(message: str) -> None:
    sim = planets()
    REFUSED[message](sim)
    with pytest.raises(ValueError, match=message):
        galvi.from_rebound(sim)
    if message.startswith("additional forces"):
        with pytest.raises(ValueError, match=message):
            galvi.judge(sim)


def test_what_is_no_simulation_is_refused() -> None:
    with pytest.raises(ValueError, match="must have particles"):
        galvi.from_rebound(rebound.Simulation())
    with pytest.raises(TypeError, match=r"source must be a rebound\.Simulation"):
        galvi.from_rebound(3)
    swing = galvi.integrate(galvi.problems.planar_pendulum(), SIX, 0.1, 2)
    with pytest.raises(ValueError, match="holds point masses"):
        swing.to_rebound()
    with pytest.raises(ValueError, match="at must be a whole number from -3 to 2"):
        galvi.integrate(galvi.from_rebound(planets()), SIX, 0.1, 2).to_rebound(at=3)


# ---------------------------------------------------------------- numbers


# Sizes of memory, which cannot be set from outside without breaking it.
MEMORY = ("N", "N_var", "N_var_config", "N_collisions")
SCALARS = [
    name
    for name, kind in rebound.Simulation._fields_
    if kind in NUMBERS
    and name not in MEMORY
    and not name.startswith(("N_allocated", "_N_", "_status"))
]


@pytest.mark.parametrize("name", SCALARS)
def test_a_number_of_a_simulation_is_read_known_to_change_nothing_or_refused(name: str) -> None:
    """It is read, or REBOUND's accelerations do not depend on it, or it is named."""
    sim, plain = planets(), planets()
    value = getattr(sim, name)
    setattr(sim, name, type(value)(1 if value != 1 else 0))
    try:
        problem = galvi.from_rebound(sim)
    except ValueError as refused:
        names = {
            "testparticle_type": "test particles",
            "_gravity": "gravity",
            "_boundary": "boundary",
            "_collision": "collision",
        }
        assert names.get(name, name) in str(refused)
        return
    before = galvi.from_rebound(plain)
    if name not in contents.READ:
        assert name.startswith(contents.HARMLESS)
        assert problem.parameters == before.parameters and problem.t0 == before.t0
        assert np.array_equal(problem.system.masses, before.system.masses)
        assert np.array_equal(contents.accelerations(sim), contents.accelerations(plain))


def test_a_field_of_a_newer_version_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: a list lacks a field that the simulation sets."""
    sim = planets(usleep=1.0)
    assert galvi.from_rebound(sim).q0.shape == (3, 3)
    remaining = tuple(field for field in contents.HARMLESS if field != "usleep")
    monkeypatch.setattr(contents, "HARMLESS", remaining)
    with pytest.raises(ValueError, match=r"usleep = 1\.0"):
        galvi.from_rebound(sim)


@pytest.mark.parametrize("fault", ["a mass", "two particles"])
def test_a_misreading_is_caught_by_the_accelerations(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    contents_of = contents.contents_of

    def wrong(sim: Any, extras: bool) -> contents.Contents:
        read_contents = contents_of(sim, extras)
        if fault == "a mass":
            return read_contents._replace(masses=read_contents.masses * [1.0, 1.0 + 1e-6, 1.0])
        return read_contents._replace(q=read_contents.q[[0, 2, 1]])

    monkeypatch.setattr(reader, "contents_of", wrong)
    with pytest.raises(ValueError, match=r"misreads this simulation: REBOUND accelerates .* by"):
        galvi.from_rebound(planets())


def test_an_encounter_in_mercurius_is_read() -> None:
    """It leaves its routine of gravity behind, called custom."""
    sim = rebound.Simulation()
    sim.add(m=1e-3, x=1.0, vy=1.0)
    sim.add(m=5e-4, x=-0.7, y=1.6, vx=-0.69, vy=-0.30)
    sim.add(m=1.0)
    sim.integrator, sim.dt = "mercurius", 0.05
    sim.steps(3)
    assert sim.gravity == "custom" and galvi.from_rebound(sim).q0.shape == (3, 3)
    sim.integrator = "leapfrog"
    with pytest.raises(ValueError, match="gravity 'custom'"):
        galvi.from_rebound(sim)


def test_a_tree_is_read_as_point_masses_and_says_so() -> None:
    sim = rebound.Simulation()
    sim.root_size = 40.0
    for position in np.random.default_rng(2).normal(size=(40, 3)):
        sim.add(m=0.01, x=position[0], y=position[1], z=position[2])
    sim.gravity = "tree"
    problem, loaded = reader.read(sim)
    assert problem.parameters["read_as"] == contents.TREE and loaded.gravity == "tree"
