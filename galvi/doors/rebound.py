"""From and to simulations of REBOUND."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.doors import rebound_contents
from galvi.doors.rebound_contents import UNITS, Contents, contents_of
from galvi.problem import Problem
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

OLDEST = 5  # version of REBOUND
READER = rebound_contents.__file__  # a program: see there


def from_rebound(source: Any, snapshot: int = -1) -> Problem:
    """The problem that a simulation of REBOUND is at.

    source    a `rebound.Simulation`, or the path of a file of one, or of an archive
    snapshot  of an archive; -1 for the last one

    Time, order, names and centre of mass of the particles are kept, and G. Those from N_active on
    become massless. A simulation that is not synchronised is synchronised in a copy.

    Raises ValueError, naming them, for additional forces, collisions, a boundary, softening,
    variational particles, test particles that pull, and a file that cannot be read;
    FileNotFoundError without a file, TypeError for another source, ModuleNotFoundError without
    REBOUND and ImportError with one older than 5.
    """
    rebound = _engine()
    if isinstance(source, str | os.PathLike):
        found = _contents_of_file(os.fspath(source), snapshot)
    elif isinstance(source, rebound.Simulation):
        found = contents_of(source)
    else:
        raise TypeError(
            f"source must be a rebound.Simulation or the path of a file of one; received "
            f"{input_checks.shown(source)}."
        )
    if found.refused:
        raise ValueError(
            f"galvi integrates point masses that attract one another; received a simulation with "
            f"{', '.join(found.refused)}. Remove them in REBOUND first."
        )
    if not found.masses.size:
        raise ValueError("the simulation must have particles; received none. Add some first.")
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


def _contents_of_file(path: str, snapshot: int) -> Contents:
    """Read in another process: REBOUND crashes at one damaged file in ten, or soon afterwards."""
    if not os.path.isfile(path):
        raise FileNotFoundError(f"there is no file {path}.")
    if isinstance(snapshot, bool) or not isinstance(snapshot, int | np.integer):
        raise ValueError(
            f"snapshot must be a whole number; received {input_checks.shown(snapshot)}. -1 is the "
            f"last one."
        )
    done = subprocess.run(
        [sys.executable, "-P", READER], input=pickle.dumps((path, int(snapshot))),
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, capture_output=True,
        check=False,
    )  # fmt: skip
    if done.returncode == 1:  # an exception of Python's
        said = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise ValueError(f"{path} must be a file of REBOUND's; reading it ended with: {said}.")
    if done.returncode != 0:
        raise ValueError(f"{path} must be a file of REBOUND's; it is damaged: REBOUND crashes.")
    found = pickle.loads(done.stdout)
    if isinstance(found, str):
        raise ValueError(found)
    return Contents(*found)
