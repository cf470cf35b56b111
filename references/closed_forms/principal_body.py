"""A rigid body in its principal axes, the form used by the compiled quaternion methods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import Problem, RigidBody
from galvi.arrays import Array
from references.newton import is_forced
from references.rigid_equations import has_known_weight, rotation


@dataclass(frozen=True, eq=False)
class PrincipalBody:
    """The constants of one problem in principal axes.

    axes     (3, 3), columns: the principal axes in the body's frame; the unit matrix for a
             diagonal inertia
    numbers  inverse moments (3,), mass g in the frame of the start (3,), centre of mass (3,), and
             whether there is weight
    """

    axes: Array
    numbers: tuple[Array, Array, Array, bool]
    p0: Array

    @staticmethod
    def of(problem: Problem) -> PrincipalBody:
        """From a problem for which `is_known_body` holds."""
        J, weight = problem.system.inertia, problem.system.potential
        moments, axes = np.diagonal(J), np.eye(3)
        if np.any(np.diag(moments) != J):
            moments, axes = np.linalg.eigh(J)
            axes = axes * np.linalg.det(axes)
        force, centre = np.zeros(3), np.zeros(3)
        if weight is not None:
            force = (problem.q0 @ axes).T @ (weight.mass * weight.g)
            centre = axes.T @ weight.centre
        numbers = (1.0 / moments, force, centre, weight is not None)
        return PrincipalBody(axes, numbers, axes.T @ problem.p0)

    def start(self) -> Array:
        """The initial state (7,): the unit quaternion, then the momentum."""
        return np.array([1.0, 0.0, 0.0, 0.0, *self.p0])

    def states(self, problem: Problem, saved: Array) -> tuple[Array, Array]:
        """R (k, 3, 3) and body momentum (k, 3) of states (k, 7), the first the start."""
        R = problem.q0 @ (self.axes @ rotation(saved[:, :4]) @ self.axes.T)
        p = saved[:, 4:] @ self.axes.T
        R[0], p[0] = problem.q0, problem.p0
        return R, p


def is_known_body(problem: Problem) -> bool:
    """Whether it is a RigidBody, free or with the weight of `galvi.UniformGravity` alone."""
    system = problem.system
    if not isinstance(system, RigidBody) or is_forced(problem):
        return False
    return system.potential is None or has_known_weight(problem)
