"""What a simulation of REBOUND holds, in values of Python and NumPy.

This file is also a program that pickles what a file of REBOUND's holds: REBOUND crashes at one
damaged file in ten, or soon afterwards, and would take the user's process with it. It imports
nothing of galvi, so that the program starts quickly.
"""

from __future__ import annotations

import os
import pickle
import sys
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

ALL_ACTIVE = (2**64 - 1, -1)  # REBOUND's N_active when it is not set
# What changes the motion from that of point masses: an attribute, and what it is called.
FUNCTIONS = {
    "_additional_forces": "additional forces",
    "_pre_timestep_modifications": "modifications before a step",
    "_post_timestep_modifications": "modifications after a step",
}
SETTINGS = {"collision": "collisions", "boundary": "a boundary"}  # "none" when there are none
UNITS = ("length", "time", "mass")


class Contents(NamedTuple):
    """What galvi takes from a simulation, in values of Python and NumPy.

    refused     what changes its motion from that of point masses, in words; then no more is read
    masses      (n,), in units of the simulation, as all that follows
    q, v        (n, 3)
    parameters  of the problem
    """

    refused: tuple[str, ...] = ()
    masses: npt.NDArray[np.float64] = np.zeros(0)
    q: npt.NDArray[np.float64] = np.zeros((0, 3))
    v: npt.NDArray[np.float64] = np.zeros((0, 3))
    t: float = 0.0
    G: float = 1.0
    parameters: dict[str, Any] = {}  # noqa: RUF012 - replaced, never changed
    units: str = ""


def contents_of(sim: Any) -> Contents:
    """Those of a `rebound.Simulation`, which is left as it is."""
    refused = tuple(_beyond_point_masses(sim))
    if refused:
        return Contents(refused)
    if not sim.is_synchronized:
        sim = sim.copy()
        sim.synchronize()
    active = sim.N if sim.N_active in ALL_ACTIVE else sim.N_active
    particles = [sim.particles[k] for k in range(sim.N)]
    return Contents(
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


def read(path: str, snapshot: int) -> Contents | str:
    """What a file holds, or why it is refused: also where REBOUND only warns, that it read a part,
    or that the simulation had functions of its own, which no file holds.
    """
    import rebound

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*might not be synchronized")
            archive = rebound.Simulationarchive(path)
            count = len(archive)
            sim = archive[snapshot] if -count <= snapshot < count else None
    except Exception as error:  # of what kind depends on which bytes are wrong
        return f"{path} must be a file of REBOUND's; it says: {error}"
    if sim is None:
        return (
            f"snapshot must be a whole number from {-count} to {count - 1}; received {snapshot}. "
            f"-1 is the last one."
        )
    return contents_of(sim)


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


if __name__ == "__main__":
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what REBOUND prints is no part of the answer
    found = read(*pickle.load(sys.stdin.buffer))
    pickle.dump(found if isinstance(found, str) else tuple(found), answer)
