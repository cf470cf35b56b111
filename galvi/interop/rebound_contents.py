"""The contents of a simulation of REBOUND as values of Python and NumPy.

This file is also a program that pickles the contents of a file of REBOUND: REBOUND crashes at one
damaged file in ten, or soon afterwards, and would end the user's process. It does not import galvi,
so that the program starts quickly.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import sys
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
ALL_ACTIVE = (2**64 - 1, -1)  # REBOUND's N_active when it is not set
# Attributes that change the motion from that of point masses -> their descriptions.
FUNCTIONS = {
    "_additional_forces": "additional forces",
    "_pre_timestep_modifications": "modifications before a step",
    "_post_timestep_modifications": "modifications after a step",
}
SETTINGS = {"collision": "collisions", "boundary": "a boundary"}  # refused unless "none"
UNITS = ("length", "time", "mass")
# The known integrators, with the fields that a user sets; INTERNAL lists the other fields.
OPTIONS = {
    "ias15": ("epsilon", "min_dt", "adaptive_mode"),
    "bs": ("eps_abs", "eps_rel", "min_dt", "max_dt"),
    "whfast": (
        "corrector",
        "corrector2",
        "kernel",
        "coordinates",
        "safe_mode",
        "keep_unsynchronized",
    ),
    "whfast512": ("corrector", "concatenate_steps"),
    "saba": ("type", "safe_mode", "keep_unsynchronized"),
    "leapfrog": ("order",),
    "eos": ("phi0", "phi1", "n", "safe_mode"),
    "janus": ("order", "scale_pos", "scale_vel"),
    "mercurius": ("r_crit_hill", "safe_mode"),
    "trace": ("r_crit_hill", "peri_crit_eta", "peri_mode"),
    "none": (),
}
INTERNAL = {
    *("p_jh", "p_jh_var", "iterations_max_exceeded", "at", "x0", "v0", "a0", "csx", "csv", "csa0"),
    *("g", "b", "csb", "e", "br", "er", "dcrit", "com_pos", "com_vel", "p_int", "data"),
    *("recalculate_integer_coordinates_this_timestep", "first_or_last_step", "previous_rejected"),
    *("target_iter", "last_synchronization"),
}
# Fields of a simulation that are read, or refused with a description.
READ = {
    *("t", "G", "dt", "softening", "N", "N_active", "N_var", "testparticle_type", "integrator"),
    *("exit_max_distance", "exit_min_distance", "is_synchronized", "python_unit_t"),
    *("python_unit_l", "python_unit_m", "_particles", "_collision", "_boundary", "_gravity"),
    *("_gravity_custom", "_additional_forces", "_pre_timestep_modifications"),
    "_post_timestep_modifications",
}
# Beginnings of the names of fields that do not change the motion of point masses: of output,
# memory, clocks, messages, names, chaos indicators, collisions and trees.
HARMLESS = (
    *("dt_last_done", "steps_done", "did_modify_particles", "_N_map", "_map", "_particles_var"),
    *("N_var_config", "var_config", "testparticle_hidewarnings", "_name", "_N_name", "gravity_cs"),
    *("N_allocated", "_tree_root", "opening_angle2", "_status", "exact_finish_time", "rand_seed"),
    *("force_is_velocity_dependent", "gravity_ignore", "_output_timing", "save_messages"),
    *("messages", "_messages", "usleep", "_display", "_server_data", "track_energy_offset"),
    *("energy_offset", "walltime", "_walltime", "root_size", "N_root", "collisions"),
    *("N_collisions", "N_targets", "minimum_collision_velocity", "_calculate_megno", "_megno"),
    *("simulationarchive", "_simulationarchive", "_heartbeat", "_key_callback", "extras"),
    *("_coefficient_of_restitution", "_collision_resolve", "_free_particle_ap", "_extras_cleanup"),
    "_N_allocated_odes",
)
TREE = "gravity 'tree' is read as that of point masses, summed directly"
LOST = (
    "the file is of a simulation with functions of its own, such as a heartbeat, which no file "
    "holds: forces among them are not in it"
)
OTHER_VERSION = "saved with a different version"
NO_POINTERS = "reset function pointers"
SWITCHES = ("mercurius", "trace")  # they set the routine of gravity themselves, in encounters


class Contents(NamedTuple):
    """The contents of a simulation, in values of Python and NumPy and in the simulation's units.

    Attributes
    ----------
    refused
        descriptions of the settings that change its motion from that of point masses; if there are
        any, nothing else is read
    masses : array, shape (n,)
        0 for test particles
    q, v, a : array, shape (n, 3)
        positions, velocities, and accelerations as REBOUND computes them
    t, G
        time and gravitational constant
    parameters, units
        of the problem
    """

    refused: tuple[str, ...] = ()
    masses: Array = np.zeros(0)
    q: Array = np.zeros((0, 3))
    v: Array = np.zeros((0, 3))
    a: Array = np.zeros((0, 3))
    t: float = 0.0
    G: float = 1.0
    parameters: dict[str, Any] = {}  # noqa: RUF012 - replaced, never changed
    units: str = ""


def contents_of(sim: Any, extras: bool = False) -> Contents:
    """The contents of a `rebound.Simulation`, which is not changed; with ``extras``, functions of
    REBOUNDx are not refused."""
    refused = tuple(_beyond_point_masses(sim, extras))
    if refused:
        return Contents(refused)
    if not sim.is_synchronized:
        sim = copied(sim)
        sim.synchronize()
    active = sim.N if sim.N_active in ALL_ACTIVE else sim.N_active
    particles = [sim.particles[k] for k in range(sim.N)]
    parameters: dict[str, Any] = {
        "bodies": tuple(p.name or str(k) for k, p in enumerate(particles)),
        "integrator": sim.integrator.name.decode(),
        "dt": sim.dt,
        "options": _options(sim),
    }
    if any(p.r for p in particles):
        parameters["radii"] = tuple(p.r for p in particles)
    for name in ("exit_max_distance", "exit_min_distance"):
        if getattr(sim, name):
            parameters[name] = getattr(sim, name)
    if sim.gravity == "tree":
        parameters["read_as"] = TREE
    return Contents(
        masses=np.array([p.m if k < active else 0.0 for k, p in enumerate(particles)]),
        q=np.array([p.xyz for p in particles]),
        v=np.array([p.vxyz for p in particles]),
        a=accelerations(sim),
        t=sim.t,
        G=sim.G,
        parameters=parameters,
        units=_units(sim),
    )


def copied(sim: Any) -> Any:
    """A copy without Python functions, and without REBOUND's warning of that."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sim.copy()


def accelerations(sim: Any, q: Any = None) -> Array:
    """Accelerations (n, 3) of a simulation's particles at their positions or at q (n, 3), by its
    routine of gravity, or by direct sums if that is a tree code or custom."""
    import rebound

    copy = copied(sim)
    copy.gravity_ignore = 0  # WHFast leaves out the pulls that its Kepler motion contains
    if copy.gravity in ("tree", "custom"):
        copy.gravity = "basic"
    if q is not None:
        for particle, position in zip(copy.particles, np.asarray(q).tolist(), strict=True):
            particle.xyz = (*position, 0.0)[:3]
    rebound.clibrebound.reb_simulation_update_acceleration(ctypes.byref(copy))
    return np.array([(p.ax, p.ay, p.az) for p in copy.particles])


def read(path: str, snapshot: int) -> Contents | str:
    """The contents of a file, or a sentence on why it is refused, such as a warning of REBOUND's
    that it read only a part."""
    import rebound

    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            archive = rebound.Simulationarchive(path)
            count = len(archive)
            sim = archive[snapshot] if -count <= snapshot < count else None
    except Exception as error:  # its class depends on which bytes are damaged
        return _another_version(path) or _no_file_of_rebounds(path, str(error))
    messages = {str(warning.message) for warning in caught}
    harmless = ("might not be synchronized", OTHER_VERSION, NO_POINTERS)
    wrong = [message for message in messages if not any(part in message for part in harmless)]
    older = any(OTHER_VERSION in message for message in messages)
    if wrong or (older and _another_version(path)):
        return _another_version(path) or _no_file_of_rebounds(path, wrong[0])
    if sim is None:
        return (
            f"snapshot must be a whole number from {-count} to {count - 1}; received {snapshot}. "
            f"-1 is the last one."
        )
    contents = contents_of(sim)
    if count > 1:
        times = np.diff([archive.t[k] for k in range(count)])
        contents.parameters["output_every"] = float(np.median(np.abs(times)))
    if older:
        contents.parameters["written_by"] = (
            f"the file was written by REBOUND {_version_of(path)} and is read by "
            f"{rebound.__version__}"
        )
    if any(NO_POINTERS in message for message in messages):
        contents.parameters["functions"] = LOST
    return contents


def _version_of(path: str) -> str:
    with open(path, "rb") as file:
        head, _, tail = file.read(64).partition(b"Version: ")
    return tail.split(b"\0")[0].decode(errors="replace") if head.startswith(b"REBOUND") else ""


def _no_file_of_rebounds(path: str, message: str) -> str:
    message = " ".join(message.split()).rstrip(".")
    return f"{path} must be a file of REBOUND's; it says: {message}."


def _another_version(path: str) -> str:
    """A sentence on what to do with a file of another major version of REBOUND; "" for a file of
    this major version."""
    import rebound

    written = _version_of(path)
    if not written or written.split(".")[0] == rebound.__version__.split(".")[0]:
        return ""
    return (
        f"{path} was written by REBOUND {written}, and files of that format are not read by "
        f"{rebound.__version__}. Load it with rebound=={written}, write masses, places and "
        f"velocities as text, and add them to a new simulation."
    )


def _beyond_point_masses(sim: Any, extras: bool) -> Iterator[str]:
    """Descriptions of the settings that change a simulation's motion from that of point masses.

    Parameters
    ----------
    extras
        whether the simulation's functions are those of REBOUNDx, which are read
    """
    for attribute, description in FUNCTIONS.items():
        if bool(getattr(sim, attribute, None)) and not extras:
            yield description
    for attribute, description in SETTINGS.items():
        if str(getattr(sim, attribute)) != "none":
            yield f"{description} ({attribute} = {getattr(sim, attribute)!r})"
    if sim.softening != 0.0:
        yield f"softening ({sim.softening:g})"
    integrator = sim.integrator.name.decode()
    switches_gravity = sim.gravity == "custom" and integrator in SWITCHES
    if sim.gravity not in ("basic", "compensated", "tree") and not switches_gravity:
        yield f"gravity {sim.gravity!r}"
    if sim.N_var:
        yield f"{sim.N_var} variational particles"
    if (
        sim.testparticle_type
        and sim.N_active not in ALL_ACTIVE
        and any(sim.particles[k].m for k in range(sim.N_active, sim.N))
    ):
        yield "test particles that pull (testparticle_type = 1)"
    yield from _unusual_settings(sim)


def _unusual_settings(sim: Any) -> Iterator[str]:
    """The fields of a simulation and of its integrator that are neither read nor harmless and
    differ from REBOUND's defaults; also an unknown integrator."""
    import rebound

    integrator, usual = sim.integrator.name.decode(), rebound.Simulation()
    for name, _ in sim._fields_:
        if name in READ or name.startswith(HARMLESS):
            continue
        if not _same(getattr(sim, name), getattr(usual, name)):
            yield f"{name.lstrip('_')} = {getattr(sim, name)!r}"
    if integrator not in OPTIONS:
        yield f"the integrator {integrator!r}, of another motion or unknown"
        return
    usual.integrator = integrator
    fields, usual_fields = _fields(sim), _fields(usual)
    for name, text in fields.items():
        if name not in (*OPTIONS[integrator], *INTERNAL) and text != usual_fields.get(name):
            yield f"{integrator}.{name} = {text}"


def _same(left: Any, right: Any) -> bool:
    if isinstance(left, int | float | type(None)):
        return bool(left == right)
    return bool(left) == bool(right)  # pointers, of which only NULL is compared


def _fields(sim: Any) -> dict[str, str]:
    """The fields of the integrator, name -> value as text."""
    assignments = [
        word.removesuffix(">").partition("=") for word in repr(sim.integrator).split(", ")[1:]
    ]
    return {name: text for name, equals, text in assignments if equals and name != "name"}


def _options(sim: Any) -> dict[str, Any]:
    """The integrator's settings, which are numbers or names."""
    options = {}
    for name in OPTIONS[sim.integrator.name.decode()]:
        value = getattr(sim.integrator, name)
        # values of REBOUND's own classes cannot be pickled
        options[name] = next(
            plain_type(value) for plain_type in (int, float, str) if isinstance(value, plain_type)
        )
    return options


def _units(sim: Any) -> str:
    units = sim.units
    if any(units[kind] is None for kind in UNITS):
        return "those of the simulation, in which G has its value"
    return ", ".join(f"{kind} {units[kind]}" for kind in UNITS)


if __name__ == "__main__":
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # REBOUND may print to stdout, which must hold the answer alone
    contents = read(*pickle.load(sys.stdin.buffer))
    pickle.dump(contents if isinstance(contents, str) else tuple(contents), answer)
