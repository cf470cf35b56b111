"""Energy and angular momentum by the textbook's formulas, one term at a time.

What a run conserves is judged by these and not by galvi's own functions, so that a wrong factor
there cannot agree with itself. q and v have shape (k, ...), results (k,) or (k, 3).
"""

from __future__ import annotations

import numpy as np

from galvi import Canonical, CentralForce, LinearSpring, NBody, Problem
from galvi.arrays import Array


def energy(problem: Problem, q: Array, v: Array) -> Array:
    """Kinetic plus potential energy, (k,). TypeError for a system without a formula here."""
    system = problem.system
    if isinstance(system, NBody):
        total = np.zeros(len(q))
        for i, mass in enumerate(system.masses):
            total += 0.5 * mass * np.sum(v[:, i] ** 2, axis=-1)
            for j in range(i):
                distance = np.sqrt(np.sum((q[:, i] - q[:, j]) ** 2, axis=-1))
                total -= system.G * mass * system.masses[j] / distance
        return total
    kinetic = 0.5 * _mass(problem) * np.sum(v**2, axis=-1)
    potential = system.potential if isinstance(system, Canonical) else None
    if isinstance(potential, LinearSpring):
        return kinetic + 0.5 * potential.stiffness * np.sum(q**2, axis=-1)
    if isinstance(potential, CentralForce):
        return kinetic - potential.mu / np.sqrt(np.sum(q**2, axis=-1))
    raise TypeError(f"there is no textbook energy here for {system!r}.")


def angular_momentum(problem: Problem, q: Array, v: Array) -> Array:
    """Sum of m q x v, (k,) in the plane and (k, 3) in space."""
    system = problem.system
    if isinstance(system, NBody):
        total = [m * _turning(q[:, i], v[:, i]) for i, m in enumerate(system.masses)]
        return np.sum(total, axis=0)
    return _mass(problem) * _turning(q, v)


def _turning(q: Array, v: Array) -> Array:
    if q.shape[-1] == 2:
        return q[..., 0] * v[..., 1] - q[..., 1] * v[..., 0]
    x, y, z = q[..., 0], q[..., 1], q[..., 2]
    a, b, c = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([y * c - z * b, z * a - x * c, x * b - y * a], axis=-1)


def _mass(problem: Problem) -> float:
    mass = problem.system.mass if isinstance(problem.system, Canonical) else np.zeros(2)
    if mass.ndim:
        raise TypeError("the textbook formulas here are for a scalar mass.")
    return float(mass)
