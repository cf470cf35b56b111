"""REBOUND's integrators with a force of REBOUNDx."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array


def versions() -> str:
    """Those of both packages."""
    import rebound
    import reboundx

    return f"REBOUND {rebound.__version__}, REBOUNDx {reboundx.__version__}"


def states(
    problem: Problem, integrator: str, dt: float, times: Array, name: str,
    own: Mapping[str, Any], first: Mapping[str, Any],
) -> tuple[Array, Array]:  # fmt: skip
    """q and v (n, bodies, 3) of bodies in space at times; steps end there.

    name   of REBOUNDx's force, "" for none; own are its parameters, first those of the first body
    """
    import rebound
    import reboundx

    system: Any = problem.system
    sim = rebound.Simulation()
    sim.G, sim.t = system.G, problem.t0
    for mass, q, v in zip(
        system.masses.tolist(), problem.q0.tolist(), problem.v0.tolist(), strict=True
    ):
        sim.add(m=mass, x=q[0], y=q[1], z=q[2], vx=v[0], vy=v[1], vz=v[2])
    extras = reboundx.Extras(sim)
    if name:
        force = extras.load_force(name)
        extras.add_force(force)
        for key, value in own.items():
            force.params[key] = value
        for key, value in first.items():
            sim.particles[0].params[key] = value
    sim.integrator, sim.dt = integrator, dt
    found = []
    for t in times:
        sim.integrate(t)
        found.append([[p.xyz, p.vxyz] for p in sim.particles])
    rows = np.array(found)
    return rows[:, :, 0], rows[:, :, 1]
