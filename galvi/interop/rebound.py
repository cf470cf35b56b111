"""Problems from simulations of REBOUND, and simulations from runs."""

from __future__ import annotations

import logging
import os
import pickle
import subprocess
import sys
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.interop import rebound_contents
from galvi.interop.rebound_contents import (
    FUNCTIONS,
    OPTIONS,
    UNITS,
    Contents,
    accelerations,
    contents_of,
    copied,
)
from galvi.interop.rebound_forces import Forced, check_forces, extras_of, forces_of
from galvi.problem import Problem
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

OLDEST_REBOUND = 5  # oldest major version of REBOUND that galvi reads
READER = rebound_contents.__file__  # the program that reads a file in another process
# Of accelerations, relative to the sum of the sizes of all pulls on a body; 4e-16 was measured for
# a few bodies, 3e-15 for a thousand.
GRAVITY_TOLERANCE = 1e-11
LOGGER = logging.getLogger("galvi")


def from_rebound(source: Any, snapshot: int = -1, *, extras: Any = None) -> Problem:
    """The problem that starts at the present state of a simulation of REBOUND.

    Parameters
    ----------
    source
        a ``rebound.Simulation``, or the path of a file of a simulation or of an archive
    snapshot
        index of the simulation in an archive; -1 for the last one
    extras
        the ``reboundx.Extras`` of a simulation, whose forces gr, gr_full, gr_potential,
        gravitational_harmonics, central_force, radiation_forces and tides_constant_time_lag are
        read, each compared with REBOUNDx's accelerations; others are refused by name. "gr" is read
        as ``Relativity(c)``, from which it differs relatively by the ratio of the planets' masses
        to the star's and, like gr_full, by terms of c^-4

    Raises
    ------
    ValueError
        Where REBOUND's accelerations differ from those of the problem, with both numbers. With the
        name of the setting, for additional forces, collisions, a boundary, softening, variational
        particles, test particles that pull, an integrator of another motion (sei), and any other
        setting that differs from REBOUND's default and may change the motion. For numbers that are
        not finite, and a file that cannot be read.
    FileNotFoundError
        Without a file.
    TypeError
        For a source of another type.
    ModuleNotFoundError
        Without REBOUND.
    ImportError
        With REBOUND older than 5.

    Notes
    -----
    The problem has the time, G, and the order, names and centre of mass of the particles. Particles
    from N_active on become massless. Of a simulation that is not synchronised a copy is
    synchronised. ``parameters`` has the names, the integrator, its step dt and its options and,
    where they are set, the radii, exit_max_distance and exit_min_distance; for an archive
    output_every, the median time between its states. ``read_as`` says that the gravity of a tree
    code is read as that of point masses, ``functions`` that a file's simulation had functions,
    which no file holds, and ``written_by`` that another version of REBOUND wrote the file.

    REBOUND's accelerations are compared with those of the problem.

    Examples
    --------
    >>> import rebound
    >>> sim = rebound.Simulation()
    >>> sim.add(m=1.0)
    >>> sim.add(m=1e-3, a=1.0, e=0.05)
    >>> galvi.from_rebound(sim).system.masses
    array([1.   , 0.001])
    """
    rebound = _engine()
    if isinstance(source, str | os.PathLike):
        if extras is not None:
            raise ValueError(
                "extras belong to a simulation; received them with a file. Load the file first."
            )
        contents = _contents_of_file(os.fspath(source), snapshot)
        _warn(os.fspath(source), contents)
    elif isinstance(source, rebound.Simulation):
        contents = contents_of(source, extras is not None)
    else:
        raise TypeError(
            f"source must be a rebound.Simulation or the path of a file of one; received "
            f"{input_checks.shown(source)}."
        )
    return _problem(contents, source, extras)


def _problem(contents: Contents, source: Any, extras: Any) -> Problem:
    """The problem of these contents, with the forces of ``extras``, those of ``source``, unless
    they are None."""
    if contents.refused:
        has_unread_extras = extras is None and bool(getattr(source, "extras", None))
        raise ValueError(
            f"galvi integrates point masses that attract one another; received a simulation with "
            f"{', '.join(contents.refused)}. {_remedy(contents.refused, has_unread_extras)}"
        )
    if not contents.masses.size:
        raise ValueError("the simulation must have particles; received none. Add some first.")
    _check_finite(contents)
    system = NBody(contents.masses, contents.G)
    _compare(system, contents.q, contents.a, contents.parameters["bodies"])
    if extras is not None:
        system = NBody(contents.masses, contents.G, forces_of(source, extras, contents))
    return Problem(
        system=system,
        q0=contents.q,
        v0=contents.v,
        t0=contents.t,
        name="from REBOUND",
        parameters=contents.parameters,
        units=contents.units,
    )


def _remedy(refused: Sequence[str], has_unread_extras: bool) -> str:
    beyond_extras = [feature for feature in refused if feature not in FUNCTIONS.values()]
    if not has_unread_extras or len(beyond_extras) == len(refused):
        return "Remove them in REBOUND first."
    give = (
        "Give the extras of REBOUNDx that add them: galvi.from_rebound(sim, extras=rebx), "
        "galvi.judge(sim, extras=rebx)."
    )
    return f"{give} Remove {', '.join(beyond_extras)} in REBOUND first." if beyond_extras else give


def read(source: Any, snapshot: int = -1, extras: str = "") -> tuple[Problem, Any]:
    """The problem, and a copy of the user's own ``rebound.Simulation`` without functions such as a
    heartbeat. Raises as `from_rebound`.

    Parameters
    ----------
    extras
        path of a file of REBOUNDx with the forces of the simulation in a file, which is then
        returned as `Forced`
    """
    if not isinstance(source, str | os.PathLike):
        return from_rebound(source, snapshot), copied(source)
    path = os.fspath(source)
    if not extras:
        return from_rebound(path, snapshot), _loaded(path, snapshot)
    if not os.path.isfile(extras):
        raise FileNotFoundError(f"there is no file {extras}.")
    contents = _contents_of_file(path, snapshot)
    contents.parameters.pop("functions", None)  # the functions are those of REBOUNDx
    _warn(path, contents)
    forced = Forced(_loaded(path, snapshot), extras)
    copy = forced.copy()
    return _problem(contents, copy, extras_of(copy)), forced


def _loaded(path: str, snapshot: int) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # already logged for the problem
        return _engine().Simulationarchive(path)[snapshot]


def check_reading(sim: Any, problem: Problem, q: Array, v: Array) -> None:
    """ValueError, with both numbers, where REBOUND's accelerations of the user's own simulation, or
    for a `Forced` one REBOUNDx's, differ from the problem's at q and v (n, 3)."""
    bodies, system = problem.parameters.get("bodies", range(len(q))), cast(NBody, problem.system)
    if isinstance(sim, Forced):
        check_forces(sim, problem, q, v)
        sim = sim.simulation
    _compare(NBody(system.masses, system.G), q, accelerations(sim, q), bodies)


def _compare(system: NBody, q: Array, expected: Array, bodies: Sequence[Any]) -> None:
    """ValueError where accelerations at rest differ from the expected ones (n, 3)."""
    expected = expected[:, : q.shape[1]]
    with np.errstate(all="ignore"):
        computed = system.acceleration(q, 0.0)
        gap = np.linalg.norm(q - q[:, None], axis=2)
        np.fill_diagonal(gap, np.inf)
        pulls = np.sum(system.G * system.masses / gap**2, axis=1)
        deviations = np.linalg.norm(computed - expected, axis=1) / np.where(pulls > 0.0, pulls, 1.0)
    if not np.max(deviations) > GRAVITY_TOLERANCE:  # also for NaN, where bodies coincide
        return
    k = int(np.argmax(deviations))
    raise ValueError(
        f"galvi misreads this simulation: REBOUND accelerates {bodies[k]} by "
        f"{expected[k].tolist()}, galvi by {computed[k].tolist()}. A force acts that galvi "
        f"does not read; please report it."
    )


def _check_finite(contents: Contents) -> None:
    for name, values in (
        ("position", contents.q),
        ("velocity", contents.v),
        ("mass", contents.masses),
    ):
        wrong = np.argwhere(~np.isfinite(values))
        if len(wrong):
            k = int(wrong[0, 0])
            raise ValueError(
                f"numbers of a simulation must be finite; received the {name} {values[k].tolist()} "
                f"of particle {k}. Correct or remove it."
            )


def to_rebound(run: Trajectory, at: int = -1) -> Any:
    """A ``rebound.Simulation`` at a saved state of a run of point masses.

    Parameters
    ----------
    at
        index of the state; -1 for the last one

    Raises
    ------
    ValueError
        For a run of another system and for a state past a failure.
    ModuleNotFoundError
        Without REBOUND.

    Notes
    -----
    The simulation has the time, G, and the order and names of the bodies; the units where REBOUND
    knows them; for a problem from REBOUND also the radii, the integrator with its options, and dt.
    """
    _engine()
    if not isinstance(run.problem.system, NBody):
        raise ValueError(
            f"a REBOUND simulation holds point masses; received a run of a "
            f"{type(run.problem.system).__name__} system."
        )
    if run.problem.system.forces:
        raise ValueError(
            "a REBOUND simulation cannot hold galvi's forces; received a run with forces. Give "
            "them to REBOUNDx, or leave them out."
        )
    at = input_checks.whole("at", at, -len(run.t), len(run.t) - 1)
    if not (np.all(np.isfinite(run.q[at])) and np.all(np.isfinite(run.v[at]))):
        raise ValueError(f"state {at} of this run was not computed: {run.status}")
    return simulation_of(replace(run.problem, q0=run.q[at], v0=run.v[at], t0=float(run.t[at])))


def simulation_of(problem: Problem) -> Any:
    """A ``rebound.Simulation`` of a problem of point masses, as `to_rebound` returns it."""
    rebound, system, parameters = _engine(), cast(NBody, problem.system), problem.parameters
    q, v = (np.pad(x, ((0, 0), (0, 3 - x.shape[1]))) for x in (problem.q0, problem.v0))
    sim = rebound.Simulation()
    units = dict(word.split(" ") for word in problem.units.split(", ") if word.count(" ") == 1)
    if set(units) == set(UNITS):
        sim.units = tuple(units[kind] for kind in UNITS)
    sim.G, sim.t = system.G, problem.t0
    names = parameters.get("bodies", ())
    radii = parameters.get("radii", ())
    for k, mass in enumerate(system.masses.tolist()):
        name = {"name": str(names[k])} if k < len(names) and str(names[k]) != str(k) else {}
        position = dict(zip(("x", "y", "z"), q[k].tolist(), strict=True))
        speed = dict(zip(("vx", "vy", "vz"), v[k].tolist(), strict=True))
        sim.add(m=mass, **position, **speed, **name, r=radii[k] if k < len(radii) else 0.0)
    heavy = int(np.count_nonzero(system.masses))
    if system.has_massless and np.all(system.masses[:heavy] > 0.0):
        sim.N_active = heavy
    if parameters.get("integrator") in OPTIONS:
        sim.integrator = parameters["integrator"]
        for key, value in parameters.get("options", {}).items():
            setattr(sim.integrator, key, value)
    sim.dt = parameters.get("dt", sim.dt)
    return sim


def _engine() -> Any:
    try:
        import rebound
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "REBOUND is not installed. Install it: pip install rebound.", name="rebound"
        ) from error
    if int(rebound.__version__.split(".")[0]) < OLDEST_REBOUND:
        raise ImportError(
            f"galvi needs REBOUND {OLDEST_REBOUND} or newer; received {rebound.__version__}. "
            f"Upgrade it: pip install -U rebound."
        )
    return rebound


def _contents_of_file(path: str, snapshot: int) -> Contents:
    """The contents of a file, read in another process, since REBOUND crashes at one damaged file in
    ten, or soon afterwards.

    Raises FileNotFoundError without a file; ValueError for a snapshot that is no whole number or
    not in the file, and for a file that cannot be read.
    """
    if not os.path.isfile(path):
        raise FileNotFoundError(f"there is no file {path}.")
    if isinstance(snapshot, bool) or not isinstance(snapshot, int | np.integer):
        raise ValueError(
            f"snapshot must be a whole number; received {input_checks.shown(snapshot)}. -1 is the "
            f"last one."
        )
    completed = subprocess.run(
        [sys.executable, "-P", READER],
        input=pickle.dumps((path, int(snapshot))),
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        check=False,
    )
    if completed.returncode == 1:  # a Python exception
        message = completed.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise ValueError(f"{path} must be a file of REBOUND's; reading it ended with: {message}.")
    if completed.returncode != 0:
        raise ValueError(f"{path} must be a file of REBOUND's; it is damaged: REBOUND crashes.")
    contents = pickle.loads(completed.stdout)
    if isinstance(contents, str):
        raise ValueError(contents)
    return Contents(*contents)


def _warn(path: str, contents: Contents) -> None:
    for name in ("written_by", "functions"):
        if name in contents.parameters:
            LOGGER.warning("%s: %s", path, contents.parameters[name])
