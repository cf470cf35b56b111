"""Extent and orientation of orbits about the first body, as measures of stability."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import Problem, Trajectory
from galvi.arrays import Array


def period(problem: Problem, body: int) -> float:
    """Period of the osculating ellipse at the start about body 0, in the problem's unit of time."""
    gm, q, v = _relative(problem, problem.q0[None], problem.v0[None], body)
    axis = 1.0 / (2.0 / np.linalg.norm(q[0]) - v[0] @ v[0] / gm)
    return float(2.0 * np.pi * np.sqrt(axis**3 / gm))


def extent(t: Array, q: Array, body: int, start: float, end: float) -> tuple[float, float]:
    """Closest and farthest distance to body 0 for t in [start, end], by parabolas through samples.

    t (k,) evenly spaced, q (k, bodies, dimension)
    """
    inside = np.flatnonzero((t >= start) & (t <= end))
    distance = np.linalg.norm(q[inside, body] - q[inside, 0], axis=-1)
    return _extreme(distance, int(np.argmin(distance))), _extreme(
        distance, int(np.argmax(distance))
    )


def perihelion(run: Trajectory, body: int) -> Array:
    """Vector towards the pericentre, as long as the eccentricity, at each saved state (k, 3)."""
    v = run.v
    gm, q, v = _relative(run.problem, run.q, v, body)
    unit = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.cross(v, np.cross(q, v)) / gm - unit


def angle(a: Array, b: Array) -> float:
    """The angle between two vectors in space, in radians."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _relative(problem: Problem, q: Array, v: Array, body: int) -> tuple[float, Array, Array]:
    """G (m_0 + m_body), and position and velocity relative to body 0."""
    system: Any = problem.system
    gm = float(system.G * (system.masses[0] + system.masses[body]))
    return gm, q[:, body] - q[:, 0], v[:, body] - v[:, 0]


def _extreme(y: Array, k: int) -> float:
    """The extremum of the parabola through y[k - 1], y[k], y[k + 1]."""
    if not 0 < k < y.size - 1:
        return float(y[k])
    bend = y[k - 1] - 2.0 * y[k] + y[k + 1]
    return float(y[k] - (y[k + 1] - y[k - 1]) ** 2 / (8.0 * bend)) if bend else float(y[k])
