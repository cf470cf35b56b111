"""Simulations of REBOUND are read whole, or refused by the name of what is not understood."""

from __future__ import annotations

import ctypes
import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.interop import rebound as reader
from galvi.interop import rebound_contents as contents

rebound = pytest.importorskip("rebound")

SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
NUMBERS = (ctypes.c_double, ctypes.c_int, ctypes.c_uint, ctypes.c_size_t, ctypes.c_long)


def planets(**fields: Any) -> Any:
    sim = rebound.Simulation()
    sim.add(m=1.0, name="Star")
    sim.add(m=1e-3, a=1.0, e=0.1)
    sim.add(m=3e-4, a=1.8, e=0.05, f=2.0)
    for name, value in fields.items():
        setattr(sim, name, value)
    return sim


def test_the_shearing_sheet_is_refused_by_name() -> None:
    """Its true place at t = pi is (0.7, -0.6 pi), that of point masses at rest (0.1, 0)."""
    sim = rebound.Simulation()
    sim.integrator, sim.dt, sim.OMEGA = "sei", 1e-3, 1.0
    sim.add(m=1e-12)
    sim.add(m=1e-12, x=0.1)
    with pytest.raises(ValueError, match=r"OMEGA = 1\.0.*the integrator 'sei'"):
        galvi.from_rebound(sim)


def test_options_that_change_the_force_are_refused_by_name() -> None:
    sim = planets()
    sim.integrator = "whfast512"
    assert galvi.from_rebound(sim).parameters["integrator"] == "whfast512"
    sim.integrator.gr_potential = 1
    with pytest.raises(ValueError, match=r"whfast512\.gr_potential = 1"):
        galvi.from_rebound(sim)


# Sizes of memory, which cannot be set from outside without breaking it.
MEMORY = ("N", "N_var", "N_var_config", "N_collisions")
SCALARS = [
    name for name, kind in rebound.Simulation._fields_
    if kind in NUMBERS and name not in MEMORY
    and not name.startswith(("N_allocated", "_N_", "_status"))
]  # fmt: skip


@pytest.mark.parametrize("name", SCALARS)
def test_a_number_of_a_simulation_is_read_known_to_change_nothing_or_refused(name: str) -> None:
    """Read: in the problem; harmless: REBOUND's accelerations are the same with it; else named."""
    sim, plain = planets(), planets()
    value = getattr(sim, name)
    setattr(sim, name, type(value)(1 if value != 1 else 0))
    try:
        found = galvi.from_rebound(sim)
    except ValueError as refused:
        words = {"testparticle_type": "test particles", "_gravity": "gravity",
                 "_boundary": "boundary", "_collision": "collision"}  # fmt: skip
        assert words.get(name, name) in str(refused)
        return
    before = galvi.from_rebound(plain)
    if name not in contents.READ:
        assert name.startswith(contents.HARMLESS)
        assert found.parameters == before.parameters and found.t0 == before.t0
        assert np.array_equal(found.system.masses, before.system.masses)
        assert np.array_equal(contents.accelerations(sim), contents.accelerations(plain))


def test_a_field_of_a_newer_version_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: the list without a field that is set."""
    sim = planets(usleep=1.0)
    assert galvi.from_rebound(sim).q0.shape == (3, 3)
    known = tuple(one for one in contents.HARMLESS if one != "usleep")
    monkeypatch.setattr(contents, "HARMLESS", known)
    with pytest.raises(ValueError, match=r"usleep = 1\.0"):
        galvi.from_rebound(sim)


@pytest.mark.parametrize("fault", ["a mass", "two particles"])
def test_a_misreading_is_caught_by_the_accelerations(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = contents.contents_of

    def wrong(sim: Any, extras: bool) -> contents.Contents:
        found = sound(sim, extras)
        if fault == "a mass":
            return found._replace(masses=found.masses * [1.0, 1.0 + 1e-6, 1.0])
        return found._replace(q=found.q[[0, 2, 1]])

    monkeypatch.setattr(reader, "contents_of", wrong)
    with pytest.raises(ValueError, match=r"misreads this simulation: REBOUND accelerates .* by"):
        galvi.from_rebound(planets())


def test_readings_agree_to_rounding_at_other_states_too(monkeypatch: pytest.MonkeyPatch) -> None:
    for integrator in ("whfast", "mercurius", "ias15"):
        sim = planets(integrator=integrator, dt=0.05)
        sim.steps(3)
        problem, own = reader.read(sim)
        moved = problem.q0 + np.random.default_rng(1).normal(size=problem.q0.shape)
        with monkeypatch.context() as patched:
            patched.setattr(reader, "GRAVITY_TOLERANCE", 1e-14)  # 4e-16
            reader.check_reading(own, problem, moved, problem.v0)
        own.particles[0].m = 1.1
        with pytest.raises(ValueError, match="misreads"):
            reader.check_reading(own, problem, moved, problem.v0)


def test_an_encounter_in_mercurius_is_read() -> None:
    """It leaves its own routine of gravity behind, called custom."""
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


@pytest.mark.slow(beside="test_the_usual_time_between_the_states_of_an_archive_is_read")
def test_a_heartbeat_and_a_patch_version_do_not_matter(
    tmp_path: Any, caplog: pytest.LogCaptureFixture
) -> None:
    sim = planets(heartbeat=lambda pointer: None)
    sim.integrate(1.0)
    there = galvi.from_rebound(sim)
    path = tmp_path / "run.bin"
    sim.save_to_file(str(path))
    with caplog.at_level(logging.WARNING, logger="galvi"):
        again, own = reader.read(path)
    assert np.array_equal(again.q0, there.q0) and own.N == 3 and not own._heartbeat
    assert "forces among them are not in it" in again.parameters["functions"]
    assert "forces among them are not in it" in caplog.text
    older = tmp_path / "older.bin"
    ours = rebound.__version__.encode()
    older.write_bytes(path.read_bytes().replace(ours, b"5.2.1"[: len(ours)], 1))
    found = galvi.from_rebound(older)
    assert np.array_equal(found.q0, there.q0)
    assert "written by REBOUND 5.2.1" in found.parameters["written_by"]
    for version in (b"4.4.9", b"3.9.3"):
        older.write_bytes(path.read_bytes().replace(ours, version, 1))
        with pytest.raises(ValueError, match=rf"by REBOUND {version.decode()}, .*Load it with"):
            galvi.from_rebound(older)


def test_what_a_simulation_has_comes_back(tmp_path: Any) -> None:
    sim = planets(integrator="whfast", dt=-0.07, exit_max_distance=50.0)
    sim.integrator.corrector, sim.integrator.kernel = 11, "LAZY"
    sim.particles[1].r = 4e-4
    problem = galvi.from_rebound(sim)
    assert problem.parameters["exit_max_distance"] == 50.0
    back = galvi.integrate(problem, SIX, -0.1, 4).to_rebound(at=0)
    assert back.integrator.name.decode() == "whfast" and back.dt == -0.07
    assert back.integrator.corrector == 11 and back.integrator.kernel == "LAZY"
    assert [p.r for p in back.particles] == [0.0, 4e-4, 0.0] and back.particles[0].name == "Star"
    assert galvi.from_rebound(back).parameters == {
        key: value for key, value in problem.parameters.items() if key != "exit_max_distance"
    }


def test_a_number_that_is_not_finite_is_said_of_its_particle() -> None:
    sim = planets()
    sim.particles[1].x = float("nan")
    with pytest.raises(ValueError, match=r"received the position \[nan, .* of particle 1"):
        galvi.from_rebound(sim)


def test_a_tree_is_read_as_point_masses_and_says_so() -> None:
    sim = rebound.Simulation()
    sim.root_size = 40.0
    for place in np.random.default_rng(2).normal(size=(40, 3)):
        sim.add(m=0.01, x=place[0], y=place[1], z=place[2])
    sim.gravity = "tree"
    problem, own = reader.read(sim)
    assert problem.parameters["read_as"] == contents.TREE and own.gravity == "tree"


def test_the_usual_time_between_the_states_of_an_archive_is_read(tmp_path: Path) -> None:
    sim, file = planets(), tmp_path / "archive.bin"
    for k in range(5):
        sim.integrate(0.7 * k)
        sim.save_to_file(str(file))
    assert galvi.from_rebound(file).parameters["output_every"] == pytest.approx(0.7)
    planets().save_to_file(str(tmp_path / "one.bin"))
    assert "output_every" not in galvi.from_rebound(tmp_path / "one.bin").parameters
