"""Transits by bisection between outputs, as users of REBOUND find them, since it has no events."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.engine_clock import engine_time
from references.rebound import simulation as rebound_simulation


def transits(
    problem: Problem,
    planets: Sequence[int],
    star: int,
    duration: float,
    interval: float,
    precision: float,
) -> list[Array]:
    """Mid-transit times since the start, an array for each planet, seen from far away along x.

    As in REBOUND's example of transit timing variations, with IAS15: y changes its sign between two
    outputs while the planet is in front of the star, and the integration goes to and fro by
    bisection.

    Parameters
    ----------
    planets
        indices of bodies, all in one run
    star
        index of the star
    interval
        time between outputs
    precision
        largest error of the times
    """
    sim = rebound_simulation.simulation(problem, "ias15", {})
    engine, transit_times = sim.engine, [list[float]() for _ in planets]
    p, s = (
        [engine.particles[int(sim.indices[body])] for body in bodies]
        for bodies in (planets, [star])
    )
    with rebound_simulation.interrupts_kept(), engine_time:
        while engine.t < duration:
            before, start = [planet.y - s[0].y for planet in p], engine.t
            engine.integrate(start + interval)
            ended = engine.t
            passed = [
                y * (planet.y - s[0].y) < 0.0 and planet.x > s[0].x
                for y, planet in zip(before, p, strict=True)
            ]
            for k in np.flatnonzero(passed).tolist():
                low, high = start, ended
                while high - low > precision:
                    engine.integrate(0.5 * (low + high))
                    if before[k] * (p[k].y - s[0].y) < 0.0:
                        high = engine.t
                    else:
                        low = engine.t
                transit_times[k].append(0.5 * (low + high))
            if any(passed):
                engine.integrate(ended)
    return [np.array(times) for times in transit_times]
