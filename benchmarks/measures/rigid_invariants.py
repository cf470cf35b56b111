"""Invariants of rigid bodies, and angles between attitudes."""

from __future__ import annotations

import numpy as np

from benchmarks.measures import independent_invariants
from galvi import Problem, RigidBody
from galvi.arrays import Array

# Invariants of a rigid body, from its rotations R (k, 3, 3) and body momenta p (k, 3).
#
# Independent of galvi's own functions, like `benchmarks.measures.independent_invariants`, and
# computed from the run's momenta, without the rounding of velocities.


def energy(problem: Problem, R: Array, p: Array) -> Array:
    """Kinetic plus potential energy, (k,); TypeError unless the system is a RigidBody with a
    textbook formula."""
    if not isinstance(problem.system, RigidBody):
        raise TypeError(f"this is a formula for a RigidBody; received {problem.system!r}.")
    return independent_invariants.energy(problem, R, p @ np.linalg.inv(problem.system.inertia))


def spatial_momentum(R: Array, p: Array) -> Array:
    """R p, (k, 3): constant without external torque."""
    return np.stack([np.sum(R[:, axis] * p, axis=-1) for axis in range(3)], axis=-1)


def orthogonality_defect(R: Array) -> Array:
    """Largest magnitude of an entry of R^T R - I, (k,)."""
    defects = [
        np.sum(R[:, :, i] * R[:, :, j], axis=-1) - (i == j) for i in range(3) for j in range(i + 1)
    ]
    return np.max(np.abs(defects), axis=0)


def turns(first: Array, second: Array) -> Array:
    """Angle of first^T second in [0, pi], (k,), for rotations (k, 3, 3); exact near 0 and pi.

    With c = (trace - 1) / 2 and s the size of the skew part, the angle is atan2(s, c).
    """
    relative = np.einsum("kji,kjl->kil", first, second)
    skew = relative - np.swapaxes(relative, 1, 2)
    sine = 0.5 * np.sqrt(skew[:, 2, 1] ** 2 + skew[:, 0, 2] ** 2 + skew[:, 1, 0] ** 2)
    return np.arctan2(sine, 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0))
