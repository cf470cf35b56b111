"""Energy and momentum maps, at steps from (q, p) or along the curve from (q, q')."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.systems.canonical import Canonical
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import VectorSystem
from galvi.systems.velocities import kinetic_energy, momentum_at, velocity_at
from galvi.trajectory import Trajectory


def energy(run: Trajectory, t: Any = None) -> Array:
    """Kinetic plus potential energy, (saved,) at steps, or of t's shape along the curve.

    For a Lagrangian, v . dL/dv - L. Raises ValueError as ``run(t)``.
    """
    times, q, p = _states(run, t)
    system = run.problem.system
    if isinstance(system, Lagrangian):
        known = None if t is None else run.velocity(t)
        v = velocity_at(system, q, p, times, run.problem.v0) if known is None else known
        return system.energy(q, v, times)
    each = kinetic_energy(system, p.reshape(-1, *run.problem.v0.shape))
    kinetic = each.reshape(times.shape)
    result: Array = kinetic + cast(VectorSystem, system).potential_energy(q, times)
    return result


def momentum_map(run: Trajectory, t: Any = None) -> Array:
    """Angular momentum about the origin: (...,) in the plane, (..., 3) in space.

    For a Canonical system of one body in the plane or in space whose mass is a number, the sum over
    the bodies of an NBody system or a Multibody, a RigidBody (about its fixed point, R p) or a
    FreeBody (about the origin). Raises ValueError for a system on which rotations of space do not
    act.
    """
    times, q, p = _states(run, t)
    system = run.problem.system
    if isinstance(system, Multibody):
        return _of_tree(run, times, q, p, t)[..., :3]
    if isinstance(system, RigidBody):
        return np.einsum("...ij,...j->...i", q, p)
    if isinstance(system, FreeBody):
        R, x = q[..., :3, :3], q[..., :3, 3]
        own, linear = (np.einsum("...ij,...j->...i", R, part) for part in (p[..., :3], p[..., 3:]))
        return own + np.cross(x, linear)
    _require_space(run)
    if q.shape[-1] == 2:
        turning = q[..., 0] * p[..., 1] - q[..., 1] * p[..., 0]
        return turning if turning.ndim == times.ndim else np.sum(turning, axis=-1)
    spatial = np.cross(q, p)
    return spatial if spatial.ndim == times.ndim + 1 else np.sum(spatial, axis=-2)


def linear_momentum(run: Trajectory, t: Any = None) -> Array:
    """Total linear momentum, (..., 2 or 3); for systems as in `momentum_map`, except a RigidBody.

    Raises ValueError for others.
    """
    times, q, p = _states(run, t)
    if isinstance(run.problem.system, Multibody):
        return _of_tree(run, times, q, p, t)[..., 3:]
    if isinstance(run.problem.system, FreeBody):
        return np.einsum("...ij,...j->...i", q[..., :3, :3], p[..., 3:])
    _require_space(run)
    return p if p.ndim == times.ndim + 1 else np.sum(p, axis=-2)


def _of_tree(run: Trajectory, times: Array, q: Array, p: Array, t: Any) -> Array:
    """Angular momentum and momentum (..., 6) of a Multibody."""
    system = cast(Multibody, run.problem.system)
    v = velocity_at(system, q, p, times, run.problem.v0) if t is None else run.velocity(t)
    found = system.tree.momenta(q.reshape(-1, run.problem.q0.size), v.reshape(-1, v.shape[-1]))
    return found.reshape(*times.shape, 6)


def _states(run: Trajectory, t: Any) -> tuple[Array, Array, Array]:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    if t is None:
        return run.t, run.q, run.p
    q, times = run(t), np.asarray(t, dtype=np.float64)
    return times, q, momentum_at(run.problem.system, q, run.velocity(t), times)


def _require_space(run: Trajectory) -> None:
    system, q0 = run.problem.system, run.problem.q0
    if isinstance(system, Lagrangian):
        raise ValueError(
            "a Lagrangian does not say how rotations and translations of space act on its group; "
            "compute their momenta from run.q and run.p, or use a galvi.Canonical, RigidBody or "
            "FreeBody system."
        )
    if isinstance(system, RigidBody):
        raise ValueError(
            "a galvi.RigidBody rotates about a point and has no linear momentum of its own; use "
            "galvi.momentum_map for its angular momentum, or a galvi.FreeBody, which moves."
        )
    in_space = isinstance(system, NBody) or (
        isinstance(system, Canonical) and q0.size in (2, 3) and system.mass.ndim == 0
    )
    if not in_space:
        raise ValueError(
            f"momentum of rotations and translations needs bodies in the plane or in space with "
            f"scalar masses; received a {type(system).__name__} system with q of shape {q0.shape}."
        )
