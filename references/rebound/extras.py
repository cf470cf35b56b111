"""REBOUND's integrators with a force of REBOUNDx."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.rebound import simulation as rebound_simulation

ADAPTIVE = ("ias15", "bs")


def missing() -> str:
    """One sentence saying why REBOUNDx cannot be used here; empty when it can."""
    if rebound_simulation.missing():
        return rebound_simulation.missing()
    try:
        import reboundx  # noqa: F401
    except ImportError as error:
        return f"{error}. Install reboundx, which is built from its source."
    return ""


def versions() -> str:
    """The versions of both packages."""
    import rebound
    import reboundx

    return f"REBOUND {rebound.__version__}, REBOUNDx {reboundx.__version__}"


def states(
    problem: Problem,
    integrator: str,
    dt: float,
    times: Array,
    name: str,
    force_parameters: Mapping[str, Any],
    of_bodies: Mapping[int, Mapping[str, Any]],
) -> tuple[Array, Array]:
    """q and v (n, bodies, 3) of bodies in space at times that are multiples of dt.

    Parameters
    ----------
    times : array, shape (n,)
        at equal distances
    name
        name of REBOUNDx's force, "" for none
    force_parameters
        parameters of the force
    of_bodies
        index of a body -> its parameters, with its radius "r"
    """
    import reboundx

    count = round((times[1] - times[0]) / dt)
    batch = {"concatenate_steps": count} if integrator == "whfast512" else {}
    simulation = rebound_simulation.simulation(problem, integrator, batch)
    sim, saved = simulation.engine, []
    sim.dt, sim.exact_finish_time = dt, integrator in ADAPTIVE
    extras = reboundx.Extras(sim)
    if name:
        force = extras.load_force(name)
        extras.add_force(force)
        for key, value in force_parameters.items():
            force.params[key] = value
        for body, parameters in of_bodies.items():
            particle = sim.particles[int(simulation.indices[body])]
            for key, value in parameters.items():
                if key == "r":
                    particle.r = value
                else:
                    particle.params[key] = value
    with rebound_simulation.arithmetic_kept(), rebound_simulation.interrupts_kept():
        for k, t in enumerate(times):
            if integrator in ADAPTIVE:
                sim.integrate(t - problem.t0)
            elif k:
                sim.steps(1 if batch else count)
            saved.append(simulation.states())
    q, v = (np.array(x) for x in zip(*saved, strict=True))
    return q, v
