"""Runs a user's own simulation of point masses: a program for the Python of any REBOUND release.

It reads a job from its input and writes an answer, both as JSON. A file of one release cannot be
read by all others, so that the job holds what the file does:

    job     "G", "t", "integrator", "step", "options" of the integrator by name, "settings" of the
            simulation by name, "particles": rows of mass, position and velocity; "runs": a list of
            {"particles", "step", which may be absent, "steps": n, "every": k} or, for an integrator
            that chooses its steps, {"particles", "times": a list}, with "rounding": seed,
            may be absent; "states": a list of particles
    answer  {"release", "runs": for each run the rows of particles at every k-th step after the
            start or at each time, of energy and the kinetic part of it, "failure", a sentence
            or "", and "taken", the number of steps;
            "accelerations": those of each body at each state, "energies": of each state}

The program assesses nothing, so that all releases are assessed alike.
"""

from __future__ import annotations

import ctypes
import json
import math
import random
import sys
import warnings
from typing import Any

STATE = ("m", "x", "y", "z", "vx", "vy", "vz")


def build(job: dict[str, Any], particles: list[list[float]]) -> Any:
    """The simulation of a job with these particles; ValueError for an option that the release
    lacks."""
    import rebound

    sim = rebound.Simulation()
    sim.G, sim.t = job["G"], job["t"]
    for row in particles:
        sim.add(**dict(zip(STATE, row, strict=True)))
    for name, value in job.get("settings", {}).items():
        setattr(sim, name, value)
    sim.integrator = job["integrator"]
    options_owner = (
        sim.integrator
        if hasattr(sim.integrator, "name")
        else (getattr(sim, f"ri_{job['integrator']}", None))
    )
    for name, value in job.get("options", {}).items():
        if not hasattr(options_owner, name):
            raise ValueError(f"This release's {job['integrator']} has no option {name}.")
        try:
            setattr(options_owner, name, value)
        except ValueError:  # 10_6_4 of SABA is 10,6,4 in releases before 5
            setattr(options_owner, name, str(value).replace("_", ","))
    return sim


def state(sim: Any) -> tuple[list[list[float]], float]:
    """The particles and the energy of a synchronised copy."""
    synchronised = sim.copy()
    (getattr(synchronised, "synchronize", None) or synchronised.integrator_synchronize)()
    energy = (getattr(synchronised, "energy", None) or synchronised.calculate_energy)()
    return [[getattr(p, name) for name in STATE] for p in synchronised.particles], float(energy)


PARTS = 100  # largest number of parts of the steps between rows; after each, rounding is imitated


def advance(sim: Any, count: int, time: float | None, signs: random.Random | None) -> None:
    """Advance to a time, or by ``count`` steps. With ``signs``, a random generator, each entry is
    perturbed by the accumulated error of one ulp a step."""
    part = count if signs is None else math.ceil(count / PARTS)
    for first in range(0, count, part):
        before = sim.steps_done if signs else 0
        if time is None:
            sim.steps(min(part, count - first))
        else:
            sim.integrate(time)
        if signs:
            ulps = math.sqrt(sim.steps_done - before) * sys.float_info.epsilon
            for p in sim.particles:
                for name in STATE[1:]:
                    setattr(p, name, getattr(p, name) * (1.0 + signs.choice((-ulps, ulps))))


def run(job: dict[str, Any], request: dict[str, Any]) -> dict[str, Any]:
    """The rows of one run of the job, up to its failure if it fails."""
    rows: dict[str, Any] = {
        "particles": [],
        "energy": [],
        "kinetic": [],
        "failure": "",
        "taken": 0,
    }
    try:
        sim = build(job, request.get("particles") or job["particles"])
        sim.dt = request.get("step") or job["step"]
        sim.exact_finish_time = int("times" in request)  # WHFast512 takes whole steps only
        signs = random.Random(request["rounding"]) if "rounding" in request else None
        for time in request.get("times") or [None] * (request["steps"] // request["every"]):
            advance(sim, request.get("every", 1), time, signs)
            particles, energy = state(sim)
            rows["particles"].append(particles)
            rows["energy"].append(energy)
            rows["kinetic"].append(
                sum(0.5 * m * (u * u + v * v + w * w) for m, _, _, _, u, v, w in particles)
            )
            rows["taken"] = sim.steps_done
    except Exception as error:  # releases raise different exceptions
        rows["failure"] = f"{type(error).__name__}: {error}"
    return rows


def accelerations(sim: Any) -> list[list[float]]:
    """Accelerations (n, 3) of the bodies."""
    import rebound

    library = rebound.clibrebound
    update = getattr(library, "reb_simulation_update_acceleration", None) or (
        library.reb_update_acceleration
    )
    update(ctypes.byref(sim))
    return [[p.ax, p.ay, p.az] for p in sim.particles]


def answer(job: dict[str, Any]) -> dict[str, Any]:
    """The answer to a job."""
    import rebound

    warnings.simplefilter("ignore")
    plain = {**job, "integrator": "leapfrog", "options": {}}
    states = [build(plain, particles) for particles in job.get("states", [])]
    return {
        "release": rebound.__version__,
        "runs": [run(job, request) for request in job.get("runs", [])],
        "energies": [state(sim)[1] for sim in states],
        "accelerations": [accelerations(sim) for sim in states],
    }


if __name__ == "__main__":
    json.dump(answer(json.load(sys.stdin)), sys.stdout)
