"""From and to simulations of REBOUND."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
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
import pickle, sys
path, sys.path, snapshot = pickle.load(sys.stdin.buffer)
from galvi.doors.rebound import _read
sys.stdout.buffer.write(pickle.dumps(_read(path, snapshot)))
"""


class Contents(NamedTuple):
    """What galvi takes from a simulation, in values of Python and NumPy.

    refused     what changes its motion from that of point masses, in words
    masses      (n,), in units of the simulation, as all that follows
    q, v        (n, 3)
    parameters  of the problem
    """

    refused: list[str]
    masses: Array
    q: Array
    v: Array
    t: float
    G: float
    parameters: dict[str, Any]
    units: str


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
    if isinstance(source, str | os.PathLike):
        found = _contents_of_file(os.fspath(source), snapshot)
    elif isinstance(source, rebound.Simulation):
        found = _contents(source)
    else:
        raise TypeError(
            f"source must be a rebound.Simulation or the path of a file of one; received "
            f"{input_checks.shown(source)}."
        )
    if not found.masses.size:
        raise ValueError("the simulation must have particles; received none. Add some first.")
    if found.refused:
        raise ValueError(
            f"galvi integrates point masses that attract one another; received a simulation with "
            f"{', '.join(found.refused)}. Remove them in REBOUND first."
        )
    return Problem(
        system=NBody(found.masses, found.G),
        q0=found.q,
        v0=found.v,
        t0=found.t,
        name="from REBOUND",
        parameters=found.parameters,
        units=found.units,
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


def _contents(sim: Any) -> Contents:
    refused = list(_beyond_point_masses(sim))
    if not sim.is_synchronized:
        sim = sim.copy()
        sim.synchronize()
    active = sim.N if sim.N_active in ALL_ACTIVE else sim.N_active
    particles = [sim.particles[k] for k in range(sim.N)]
    return Contents(
        refused=refused,
        masses=np.array([p.m if k < active else 0.0 for k, p in enumerate(particles)]),
        q=np.array([p.xyz for p in particles]),
        v=np.array([p.vxyz for p in particles]),
        t=sim.t,
        G=sim.G,
        parameters={
            "bodies": tuple(p.name or str(k) for k, p in enumerate(particles)),
            "integrator": sim.integrator.name.decode(),
            "dt": sim.dt,
            "options": _options(sim),
        },
        units=_units(sim),
    )


def _contents_of_file(path: str, snapshot: int) -> Contents:
    """Read in another process: REBOUND crashes at one damaged file in ten, or soon afterwards."""
    if not os.path.isfile(path):
        raise FileNotFoundError(f"there is no file {path}.")
    which = input_checks.whole("snapshot", snapshot, -input_checks.LARGEST)
    done = subprocess.run(
        [sys.executable, "-c", READ],
        input=pickle.dumps((path, sys.path, which)), capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise ValueError(f"{path} must be a file of REBOUND's; it is damaged: REBOUND crashes.")
    found = pickle.loads(done.stdout)
    if not isinstance(found, Contents):
        raise ValueError(found)
    return found


def _read(path: str, snapshot: int) -> Contents | str:
    """What a file holds, or why it is refused: also where REBOUND only warns, that it read a part,
    or that the simulation had functions of its own, which no file holds.
    """
    rebound = _engine()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*might not be synchronized")
            archive = rebound.Simulationarchive(path)
            count = len(archive)
            if -count <= snapshot < count:
                return _contents(archive[snapshot])
    except Exception as error:  # of what kind depends on which bytes are wrong
        return f"{path} must be a file of REBOUND's; it says: {error}"
    return (
        f"snapshot must be a whole number from {-count} to {count - 1}; received {snapshot}. "
        f"-1 is the last one."
    )


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
            kind = next((one for one in (int, float, str) if isinstance(value, one)), None)
            if kind:  # REBOUND's are of classes of its own, which cannot be pickled
                found[name] = kind(value)
    return found


def _units(sim: Any) -> str:
    units = sim.units
    if any(units[kind] is None for kind in UNITS):
        return "those of the simulation, in which G has its value"
    return ", ".join(f"{kind} {units[kind]}" for kind in UNITS)
