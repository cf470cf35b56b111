"""From and to simulations of REBOUND."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.problem import Problem
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

ALL_ACTIVE = (2**64 - 1, -1)  # REBOUND's N_active when it is not set
# What changes the motion from that of point masses: an attribute, and what it is called.
FUNCTIONS = {
    "_additional_forces": "additional forces",
    "_pre_timestep_modifications": "modifications before a step",
    "_post_timestep_modifications": "modifications after a step",
}
SETTINGS = {"collision": "collisions", "boundary": "a boundary"}  # "none" when there are none
OLDEST = 5  # version of REBOUND
UNITS = ("length", "time", "mass")
READ = """
import sys, rebound
sim = rebound.Simulationarchive(sys.argv[1])[int(sys.argv[2])]
print([p.xyz for p in sim.particles])
"""


def from_rebound(source: Any, snapshot: int = -1) -> Problem:
    """The problem that a simulation of REBOUND is at.

    source    a `rebound.Simulation`, or the path of a file of one, or of an archive
    snapshot  of an archive; -1 for the last one

    Time, order, names and centre of mass of the particles are kept, and G. Those from N_active on
    become massless. A simulation that is not synchronised is synchronised in a copy.

    Raises ValueError, naming them, for additional forces, collisions, a boundary, softening,
    variational particles, test particles that pull, and a file that cannot be read;
    ModuleNotFoundError without REBOUND.
    """
    rebound = _engine()
    sim = source
    if isinstance(source, str | os.PathLike):
        sim = _snapshot(rebound, os.fspath(source), snapshot)
    if not isinstance(sim, rebound.Simulation):
        raise TypeError(
            f"source must be a rebound.Simulation or the path of a file of one; received "
            f"{input_checks.shown(source)}."
        )
    if sim.N == 0:
        raise ValueError("the simulation must have particles; received none. Add some first.")
    refused = list(_beyond_point_masses(sim))
    if refused:
        raise ValueError(
            f"galvi integrates point masses that attract one another; received a simulation with "
            f"{', '.join(refused)}. Remove them in REBOUND first."
        )
    if not sim.is_synchronized:
        sim = sim.copy()
        sim.synchronize()
    active = sim.N if sim.N_active in ALL_ACTIVE else sim.N_active
    particles = [sim.particles[k] for k in range(sim.N)]
    masses = np.array([p.m if k < active else 0.0 for k, p in enumerate(particles)])
    return Problem(
        system=NBody(masses, sim.G),
        q0=np.array([p.xyz for p in particles]),
        v0=np.array([p.vxyz for p in particles]),
        t0=sim.t,
        name="from REBOUND",
        parameters={
            "bodies": tuple(p.name or str(k) for k, p in enumerate(particles)),
            "integrator": sim.integrator.name.decode(),
            "dt": sim.dt,
            "options": _options(sim),
        },
        units=_units(sim),
    )


def to_rebound(run: Trajectory, at: int = -1) -> Any:
    """A `rebound.Simulation` at a saved state of a run of point masses.

    at  index of the state; -1 for the last one

    Time, order and names of the bodies are kept, and G; units where they are REBOUND's. Raises
    ValueError for a run of another system and for a state past a failure, ModuleNotFoundError
    without REBOUND.
    """
    rebound, problem = _engine(), run.problem
    system = problem.system
    if not isinstance(system, NBody):
        raise ValueError(
            f"a REBOUND simulation holds point masses; received a run of a "
            f"{type(system).__name__} system."
        )
    at = input_checks.whole("at", at, -len(run.t), len(run.t) - 1)
    q, v = (np.pad(x[at], ((0, 0), (0, 3 - x.shape[2]))) for x in (run.q, run.v))
    if not (np.all(np.isfinite(q)) and np.all(np.isfinite(v))):
        raise ValueError(f"state {at} of this run was not computed: {run.status}")
    sim = rebound.Simulation()
    units = dict(word.split(" ") for word in problem.units.split(", ") if word.count(" ") == 1)
    if set(units) == set(UNITS):
        sim.units = tuple(units[kind] for kind in UNITS)
    sim.G, sim.t = system.G, float(run.t[at])
    names = problem.parameters.get("bodies", ())
    for k, mass in enumerate(system.masses.tolist()):
        name = {"name": names[k]} if k < len(names) and names[k] != str(k) else {}
        place = dict(zip(("x", "y", "z"), q[k].tolist(), strict=True))
        speed = dict(zip(("vx", "vy", "vz"), v[k].tolist(), strict=True))
        sim.add(m=mass, **place, **speed, **name)
    heavy = int(np.count_nonzero(system.masses))
    if system.has_massless and np.all(system.masses[:heavy] > 0.0):
        sim.N_active = heavy
    return sim


def _engine() -> Any:
    try:
        import rebound
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "REBOUND is not installed. Install it: pip install rebound.", name="rebound"
        ) from error
    if int(rebound.__version__.split(".")[0]) < OLDEST:
        raise ImportError(
            f"galvi needs REBOUND {OLDEST} or newer; received {rebound.__version__}. Upgrade it: "
            f"pip install -U rebound."
        )
    return rebound


def _snapshot(rebound: Any, path: str, snapshot: int) -> Any:
    if not os.path.isfile(path):
        raise FileNotFoundError(f"there is no file {path}.")
    # REBOUND crashes at one damaged file in ten, and would take this process with it.
    command = [sys.executable, "-c", READ, path, str(snapshot)]
    if subprocess.run(command, capture_output=True, check=False).returncode < 0:
        raise ValueError(f"{path} must be a file of REBOUND's; it is damaged: REBOUND crashes.")
    with _told(path):
        archive = rebound.Simulationarchive(path)
        count = len(archive)
    which = input_checks.whole("snapshot", snapshot, -count, count - 1)
    with _told(path):
        return archive[which]


@contextmanager
def _told(path: str) -> Iterator[None]:
    """ValueError for what REBOUND says against a file, also where it only warns: that it read a
    part, or that the simulation had functions of its own, which no file holds.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*might not be synchronized")
            yield
    except (RuntimeError, ValueError, OSError, Warning) as error:
        raise ValueError(f"{path} must be a file of REBOUND's; it says: {error}") from error


def _beyond_point_masses(sim: Any) -> Iterator[str]:
    for attribute, words in FUNCTIONS.items():
        if bool(getattr(sim, attribute, None)):
            yield words
    for attribute, words in SETTINGS.items():
        if str(getattr(sim, attribute)) != "none":
            yield f"{words} ({attribute} = {getattr(sim, attribute)!r})"
    if sim.softening != 0.0:
        yield f"softening ({sim.softening:g})"
    if sim.gravity in ("custom", "none"):
        yield f"gravity {sim.gravity!r}"
    if sim.N_var:
        yield f"{sim.N_var} variational particles"
    if sim.testparticle_type and sim.N_active not in ALL_ACTIVE and any(
        sim.particles[k].m for k in range(sim.N_active, sim.N)
    ):  # fmt: skip
        yield "test particles that pull (testparticle_type = 1)"


def _options(sim: Any) -> dict[str, Any]:
    """The integrator's settings, where they are numbers or names."""
    found = {}
    for word in repr(sim.integrator).split(", ")[1:]:
        name, equals, text = word.partition("=")
        if equals and name != "name" and not text.startswith(("None", "<", "[", "0x")):
            value = getattr(sim.integrator, name)
            if isinstance(value, int | float | str):
                found[name] = value
    return found


def _units(sim: Any) -> str:
    units = sim.units
    if any(units[kind] is None for kind in UNITS):
        return "those of the simulation, in which G has its value"
    return ", ".join(f"{kind} {units[kind]}" for kind in UNITS)
