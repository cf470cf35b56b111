"""What the exact motion conserves, at steps from (q, p) or along the curve from (q, q')."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory


def energy(run: Trajectory, t: Any = None) -> Array:
    """Kinetic plus potential energy, (saved,) at steps, or of t's shape along the curve.

    Raises ValueError as ``run(t)`` does.
    """
    times, q, p = _states(run, t)
    system = run.problem.system
    axes = tuple(range(times.ndim, p.ndim))
    kinetic = 0.5 * np.sum(p * system.velocity(p), axis=axes)
    result: Array = kinetic + system.potential_energy(q, times)
    return result


def momentum_map(run: Trajectory, t: Any = None) -> Array:
    """Angular momentum about the origin: (...,) in the plane, (..., 3) in space.

    For a Canonical system of one body in the plane or in space, or the sum over the bodies of an
    NBody system. Raises ValueError for a configuration that rotations do not act on.
    """
    times, q, p = _states(run, t)
    _require_space(run)
    if q.shape[-1] == 2:
        turning = q[..., 0] * p[..., 1] - q[..., 1] * p[..., 0]
        return turning if turning.ndim == times.ndim else np.sum(turning, axis=-1)
    spatial = np.cross(q, p)
    return spatial if spatial.ndim == times.ndim + 1 else np.sum(spatial, axis=-2)


def linear_momentum(run: Trajectory, t: Any = None) -> Array:
    """Total linear momentum, (..., 2 or 3); for systems as in `momentum_map`."""
    times, _, p = _states(run, t)
    _require_space(run)
    return p if p.ndim == times.ndim + 1 else np.sum(p, axis=-2)


def _states(run: Trajectory, t: Any) -> tuple[Array, Array, Array]:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {run!r}.")
    if t is None:
        return run.t, run.q, run.p
    return np.asarray(t, dtype=np.float64), run(t), run.problem.system.momentum(run.velocity(t))


def _require_space(run: Trajectory) -> None:
    system, q0 = run.problem.system, run.problem.q0
    in_space = isinstance(system, NBody) or (
        isinstance(system, Canonical) and q0.size in (2, 3) and system.mass.ndim == 0
    )
    if not in_space:
        raise ValueError(
            f"momentum of rotations and translations needs bodies in the plane or in space with "
            f"scalar masses; received a {type(system).__name__} system with q of shape {q0.shape}."
        )
