"""Close passages and transits as users of REBOUND find them, which has no events: from states at
outputs or ends of steps, and by bisection."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.engine_clock import engine_time
from references.rebound import simulation as rebound_simulation


def relative_states(
    problem: Problem, i: int, j: int, duration: float, every: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Times since the start (k,), q_i - q_j and v_i - v_j (k, 3) of a run by IAS15, forwards.

    every  time between outputs; None: at the ends of its steps, and at the end
    """
    sim = rebound_simulation.simulation(problem, "ias15", options or {})
    engine, rows = sim.engine, []
    a, b = (engine.particles[int(sim.place[body])] for body in (i, j))

    def keep() -> None:
        rows.append((
            engine.t, a.x - b.x, a.y - b.y, a.z - b.z, a.vx - b.vx, a.vy - b.vy, a.vz - b.vz,
        ))  # fmt: skip

    with rebound_simulation.interrupts_kept(), engine_time:
        keep()
        if every is None:
            while engine.t < duration:
                engine.steps(1)
                keep()
        else:
            for k in range(1, math.floor(duration / every * (1.0 + 1e-12)) + 1):
                engine.integrate(k * every, exact_finish_time=1)
                keep()
    found = np.array(rows)
    return found[:, 0], found[:, 1:4], found[:, 4:]


def nearest_sample(t: Array, q: Array, v: Array) -> tuple[float, float]:
    """Time and distance of the state with the least distance."""
    far = np.linalg.norm(q, axis=1)
    row = int(np.argmin(far))
    return float(t[row]), float(far[row])


def nearest_on_cubics(t: Array, q: Array, v: Array) -> tuple[float, float]:
    """As `nearest_sample`, also of the cubics between two states where q . v changes its sign."""
    from scipy.interpolate import CubicHermiteSpline

    rate = np.sum(q * v, axis=1)
    best = nearest_sample(t, q, v)
    for k in np.flatnonzero((rate[:-1] < 0.0) & (rate[1:] > 0.0)).tolist():
        ends = slice(k, k + 2)
        cubic = np.polynomial.Polynomial([0.0])
        for axis in range(3):
            piece = CubicHermiteSpline(t[ends] - t[k], q[ends, axis], v[ends, axis]).c[::-1, 0]
            cubic = cubic + np.polynomial.Polynomial(piece) ** 2
        roots = cubic.deriv().roots()
        inside = roots.real[(abs(roots.imag) < 1e-12 * t[-1]) & (roots.real >= 0.0)]
        for x in inside[inside <= t[k + 1] - t[k]].tolist():
            best = min(best, (float(t[k] + x), math.sqrt(cubic(x))), key=lambda one: one[1])
    return best


def transits(
    problem: Problem, planets: Sequence[int], star: int, duration: float, every: float,
    precision: float, integrator: str = "ias15", options: Mapping[str, Any] | None = None,
    step: float | None = None,
) -> list[Array]:  # fmt: skip
    """Mid-transit times since the start of each planet, seen from far away along x, as REBOUND's
    example of transit timing variations finds them: y changes its sign between two outputs while
    the planet is in front, and the integration goes to and fro by bisection.

    planets    numbers of bodies, all in one run
    every      time between outputs
    precision  of the times
    step       of an integrator with equal steps
    """
    sim = rebound_simulation.simulation(problem, integrator, options or {})
    engine, found = sim.engine, [list[float]() for _ in planets]
    p, s = ([engine.particles[int(sim.place[body])] for body in bodies]
            for bodies in (planets, [star]))  # fmt: skip
    if step is not None:
        engine.dt = step
    with rebound_simulation.interrupts_kept(), engine_time:
        while engine.t < duration:
            before, begun = [planet.y - s[0].y for planet in p], engine.t
            engine.integrate(begun + every)
            ended = engine.t
            passed = [y * (planet.y - s[0].y) < 0.0 and planet.x > s[0].x
                      for y, planet in zip(before, p, strict=True)]  # fmt: skip
            for k in np.flatnonzero(passed).tolist():
                low, high = begun, ended
                while high - low > precision:
                    engine.integrate(0.5 * (low + high))
                    if before[k] * (p[k].y - s[0].y) < 0.0:
                        high = engine.t
                    else:
                        low = engine.t
                found[k].append(0.5 * (low + high))
            if any(passed):
                engine.integrate(ended)
    return [np.array(times) for times in found]
