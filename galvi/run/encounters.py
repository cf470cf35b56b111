"""Names the point masses for which a step could not be solved, or is too long."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.kernels.forces.passages import UNRESOLVED
from galvi.problem import Problem
from galvi.systems.nbody import NBody

FAR = 1e100  # largest length whose square is safe from overflow
SOLVABLE = 0.5  # largest solvable step / sqrt(r^3 / G(m_i + m_j)), per stage


@np.errstate(all="ignore")
def encounter(problem: Problem, system: NBody, stages: int, step: float, state: Array) -> str:
    """The bodies for which the step from ``state`` failed, and the remedy, as a sentence.

    Either a body that is too far away, or the pair with the shortest time scale.
    """
    q, v = (state[row].reshape(problem.q0.shape) for row in (0, 2))
    masses, G = system.masses, system.G
    names = _names(problem, len(masses))
    distance = np.max(np.abs(q), axis=1)
    lost = int(np.argmax(distance))
    if abs(step) > FAR or np.max(np.abs(v)) > FAR:
        return "steps and velocities above 1e100 overflow. Use other units, or a smaller step."
    if not distance[lost] < FAR:
        return f"body {names[lost]} is {distance[lost]:.1e} away. Remove it, or stop before then."
    i, j = np.triu_indices(len(masses), 1)
    gap, speed = q[j] - q[i], v[j] - v[i]
    rate = np.sum(speed**2, axis=1)
    nearest = -np.sum(gap * speed, axis=1) / np.where(rate > 0.0, rate, 1.0)
    passing = np.clip(nearest, min(step, 0.0), max(step, 0.0))
    closest = np.linalg.norm(gap + passing[:, None] * speed, axis=1)
    pace = np.sqrt(
        np.minimum(closest, np.linalg.norm(gap, axis=1)) ** 3 / (G * (masses[i] + masses[j]))
    )
    pair = int(np.argmin(pace))
    solvable = SOLVABLE * stages * pace[pair]
    bodies = f"bodies {names[i[pair]]} and {names[j[pair]]}"
    if solvable < 1e-6 * abs(step):
        return f"{bodies} collide. Stop before then, or merge them."
    return (
        f"{bodies} pass at a distance of about {closest[pair]:.1e}, where steps of up to about "
        f"{solvable:.1e} can be solved; received {abs(step):g}. Use a smaller step or a higher "
        f"degree."
    )


def unresolved_passage(problem: Problem, step: float, passage: Array) -> str:
    """The worst passage of two bodies, see galvi.kernels.forces.passages, if it is unresolved."""
    if passage.size == 0 or not passage[0] > UNRESOLVED:
        return ""
    error, one, other, distance, number = passage
    names, t = _names(problem, problem.q0.shape[0]), problem.t0 + (number - 0.5) * step
    return (
        f"bodies {names[int(one)]} and {names[int(other)]} passed at a distance of about "
        f"{distance:.1e} near t = {t:.10g}, which left an error of "
        f"about {error:.0e} in their relative velocity"
    )


def _names(problem: Problem, bodies: int) -> Sequence[Any]:
    names = problem.parameters.get("bodies")
    if not isinstance(names, (tuple, list)) or len(names) != bodies:
        return range(bodies)
    return names
