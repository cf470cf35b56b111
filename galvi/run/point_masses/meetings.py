"""Whether bodies on Kepler orbits can pass each other closely."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from galvi.arrays import Array
from galvi.kernels.forces.passages import PASSAGE_REACH
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.nbody import NBody

ORBIT_MARGIN = 0.1  # share by which orbits may change before `can_meet` is evaluated again
MAX_PAIRS = 16  # largest number of compared pairs of orbits; with more some are assumed to meet
ORBIT_POINTS = (128, 512)  # points of an orbit; the larger number where the smaller does not decide
BEND_HILL_RADII = 0.7  # Hill radii by which two orbits bend each other before they pass


@lru_cache(maxsize=32)
def can_meet(
    problem: Problem,
    positions: tuple[float, ...],
    velocities: tuple[float, ...],
    method: Galerkin,
    step: float,
) -> bool:
    """Whether two bodies may pass each other so closely that `may_pass` examines them, wherever
    they are on the orbits of a state about the heaviest body, which may change by
    ``ORBIT_MARGIN``."""
    system = problem.system
    if not isinstance(system, NBody):
        return False
    q, v = (np.array(rows).reshape(problem.q0.shape) for rows in (positions, velocities))
    star, masses = int(np.argmax(system.masses)), system.masses
    planets = np.flatnonzero(np.arange(masses.size) != star)
    mu, q, v = (
        system.G * (masses[star] + masses[planets]),
        q[planets] - q[star],
        v[planets] - v[star],
    )
    r, square_speed, radial = np.linalg.norm(q, axis=1), np.sum(v**2, axis=1), np.sum(q * v, axis=1)
    with np.errstate(all="ignore"):
        energy, square_momentum = (
            square_speed - 2.0 * mu / r,
            np.maximum(r**2 * square_speed - radial**2, 0.0),
        )
        e = np.sqrt(np.maximum(1.0 + energy * square_momentum / mu**2, 0.0))
        pericentre = square_momentum / (mu * (1.0 + e)) / (1.0 + ORBIT_MARGIN)
        apocentre = np.where(e < 1.0, square_momentum / (mu * (1.0 - e)), np.inf) * (
            1.0 + ORBIT_MARGIN
        )
    separate = (pericentre[:, None] > apocentre) | (pericentre > apocentre[:, None])
    separate |= np.add.outer(masses[planets], masses[planets]) == 0.0
    time = 2.0 * PASSAGE_REACH * abs(step) / (method.space.dimension - 1)
    if np.count_nonzero(np.triu(~separate, 1)) > MAX_PAIRS:
        return True
    return any(
        not (e[i] < 1.0 and e[j] < 1.0) or _orbits_near(mu, q, v, i, j, time, pull)
        for i, j in np.argwhere(np.triu(~separate, 1))
        if (pull := system.G * (masses[planets[i]] + masses[planets[j]]))
    )


def _orbits_near(mu: Array, q: Array, v: Array, i: int, j: int, time: float, pull: float) -> bool:
    """Whether the distance of two ellipses somewhere is less than the bodies' relative velocity and
    own attraction move them in a time, together with the bend of their orbits.

    Where the ellipses are nearest, their distance is perpendicular to both; points beside those add
    the square of their spacing.
    """
    bend = (
        BEND_HILL_RADII
        * max(float(np.linalg.norm(q[k])) for k in (i, j))
        * np.cbrt(pull / (3.0 * mu[i]))
    )
    bend += np.cbrt(2.0 * pull * time**2)
    for count in ORBIT_POINTS:
        first, second = (_ellipse(float(mu[k]), q[k], v[k], count) for k in (i, j))
        square, square_speeds = (
            np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1) - 2.0 * a @ b.T
            for a, b in zip(first[:2], second[:2], strict=True)
        )
        square_spacing = 0.25 * (first[2] + second[2]) ** 2
        reach = time * np.sqrt(np.maximum(square_speeds, 0.0)) + bend
        if not np.any((1.0 - ORBIT_MARGIN) ** 2 * square - square_spacing < reach**2):
            return False
    return True


def _ellipse(mu: float, q: Array, v: Array, count: int) -> tuple[Array, Array, float]:
    """Positions and velocities (count, dimension) on the ellipse of a state, and the largest
    distance of two neighbours."""
    r = np.linalg.norm(q)
    eccentricity_vector = ((v @ v - mu / r) * q - (q @ v) * v) / mu
    a, e = float(mu / (2.0 * mu / r - v @ v)), float(np.linalg.norm(eccentricity_vector))
    major_axis = eccentricity_vector / e if e > 0.0 else q / r
    minor_axis = (
        q - (q @ major_axis) * major_axis
        if abs(q @ major_axis) < 0.7 * r
        else v - (v @ major_axis) * major_axis
    )
    minor_axis = minor_axis / np.linalg.norm(minor_axis)
    minor_axis = (
        minor_axis
        if (v @ minor_axis) * (q @ major_axis) >= (v @ major_axis) * (q @ minor_axis)
        else -minor_axis
    )
    u = 2.0 * np.pi * np.arange(count)[:, None] / count
    minor = a * math.sqrt(max(1.0 - e * e, 0.0))
    positions = a * (np.cos(u) - e) * major_axis + minor * np.sin(u) * minor_axis
    anomaly_rate = np.sqrt(mu / a**3) / (1.0 - e * np.cos(u))
    velocities = anomaly_rate * (minor * np.cos(u) * minor_axis - a * np.sin(u) * major_axis)
    return positions, velocities, 2.0 * np.pi * a / count
