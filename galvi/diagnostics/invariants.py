"""Energy and momenta of a run, and the balance of momentum under forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.diagnostics.symplecticity import stage_states
from galvi.groups.group import SE3, SO3
from galvi.input_checks import flag, shown
from galvi.systems.canonical import Canonical
from galvi.systems.forces.external_force import force_at
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian, kinetic_energy, momentum_at, velocity_at
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import VectorSystem
from galvi.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


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
    return kinetic + cast(VectorSystem, system).potential_energy(q, times)


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


@dataclass(frozen=True, eq=False)
class MomentumBalance:
    """A momentum at each step and the impulses that changed it; arrays of the same shape.

    t          (steps + 1,)
    momentum   (steps + 1, ...) as `galvi.momentum_map` or `galvi.linear_momentum` gives it
    potential  impulse of the potential since the start
    force      impulse of the external force since the start

    momentum - momentum[0] - potential - force is ``defect``: round-off for every space and rule,
    since the stage equations hold for the variations that translate or rotate a curve (the forced
    discrete theorem of Noether: Marsden and West, Acta Numerica 10 (2001), 3.2.3); with degrees
    for each component a rotation is no such variation, and the defect says how much that matters.
    """

    t: Array
    momentum: Array
    potential: Array
    force: Array

    @property
    def defect(self) -> Array:
        """The change of momentum that neither impulse explains, in momentum's shape."""
        return self.momentum - self.momentum[0] - self.potential - self.force


def momentum_balance(run: Trajectory, *, linear: bool = False) -> MomentumBalance:
    """The balance of angular momentum about the origin or, if ``linear``, of linear momentum.

    For a Canonical system of one body in the plane or in space with its curves kept, or a
    RigidBody, which has angular momentum only. Raises ValueError for another system and for a run
    without curves at every step.
    """
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    system: Any = run.problem.system
    if not isinstance(system, Canonical | RigidBody):
        raise ValueError(
            f"the balance of momentum is for a Canonical system of one body or a RigidBody; "
            f"received a {type(system).__name__} system."
        )
    momentum = linear_momentum(run) if flag("linear", linear) else momentum_map(run)
    t, q, v, weights = stage_states(run)
    if len(momentum) != len(t) + 1:
        raise ValueError("the balance of momentum needs every step; integrate with save_every=1.")
    of_potential, of_force = np.zeros((2, *q.shape[:2], run.problem.v0.size))
    for step, stage in np.ndindex(q.shape[:2]):
        state = q[step, stage], float(t[step, stage])
        if not np.all(np.isfinite(q[step, stage])):
            of_potential[step, stage] = of_force[step, stage] = np.nan
            continue
        of_potential[step, stage] = _potential_force(system, *state)
        of_force[step, stage] = force_at(system, state[0], v[step, stage], state[1])
    impulses = [_impulse(part, q, weights, linear) for part in (of_potential, of_force)]
    return MomentumBalance(run.t, momentum, *impulses)


def _potential_force(system: Canonical | RigidBody, q: Array, t: float) -> Array:
    if isinstance(system, RigidBody):
        return system.torque(q, t)
    return -system.potential_gradient(q, t)


def _impulse(forces: Array, q: Array, weights: Array, linear: bool) -> Array:
    """Accumulated impulse (steps + 1, ...) of forces (steps, s, d) at configurations q."""
    if q.ndim == 4:
        turning = np.einsum("ksab,ksb->ksa", q, forces)
    elif linear:
        turning = forces
    elif q.shape[-1] == 2:
        turning = q[..., 0] * forces[..., 1] - q[..., 1] * forces[..., 0]
    else:
        turning = np.cross(q, forces)
    each = np.tensordot(turning, weights, axes=(1, 0))
    return read_only(np.concatenate([np.zeros((1, *each.shape[1:])), np.cumsum(each, axis=0)]))


def rotations(run: Trajectory, t: Any = None) -> Rotation:
    """The attitudes at steps, or on the curve at t, as `scipy.spatial.transform.Rotation`.

    It converts further: ``.as_quat(scalar_first=True)``, ``.as_euler("zyx")``, ``.magnitude()``.
    For runs on SO(3) and SE(3); raises ValueError for others and for states past a failure,
    TypeError for something that is not a Trajectory.
    """
    R = _matrices(run, t)
    if not np.all(np.isfinite(R)):
        raise ValueError(
            "the run failed, and its states past the failure are NaN; take them out first, e.g. "
            "with t up to the failed step."
        )
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    return Rotation.from_matrix(R)


def orthogonality_defect(run: Trajectory, t: Any = None) -> Array:
    """The largest entry of |R^T R - I|, (saved,) at steps, or of t's shape on the curve."""
    R = _matrices(run, t)
    square = np.einsum("...ki,...kj->...ij", R, R)
    return np.max(np.abs(square - np.eye(3)), axis=(-2, -1))


def _matrices(run: Trajectory, t: Any) -> Array:
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    group = getattr(run.problem.system, "group", None)
    if not isinstance(group, (SO3, SE3)):
        raise ValueError(
            f"attitudes need a run on SO(3) or SE(3), such as of a galvi.RigidBody; received "
            f"{run!r}."
        )
    q: Array = run.q if t is None else run(t)
    return q[..., :3, :3]
