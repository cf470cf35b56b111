"""Balance of momentum: its change against the impulses of the potential and the force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.diagnostics.invariants import linear_momentum, momentum_map
from galvi.diagnostics.stage_states import stage_states
from galvi.input_checks import shown
from galvi.systems.canonical import Canonical
from galvi.systems.forces.external_force import force_at
from galvi.systems.rigid_body import RigidBody
from galvi.trajectory import Trajectory


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
        result: Array = self.momentum - self.momentum[0] - self.potential - self.force
        return result


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
    momentum = linear_momentum(run) if linear else momentum_map(run)
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
