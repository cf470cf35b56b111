"""A body in its principal axes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from galvi import Problem, RigidBody
from galvi.arrays import Array
from galvi.extended_precision import decimals
from references.closed_forms.decimal_trigonometry import SMALLEST
from references.newton import is_forced
from references.rigid_equations import has_known_weight, rotation

SWEEPS = 20


def principal_axes(inertia: Any) -> tuple[Any, Any]:
    """Moments (3,), ascending, and axes as columns of an orthogonal (3, 3), by Jacobi's method.

    inertia  (3, 3) symmetric, of decimals; call inside ``localcontext(DIGITS)``

    Those of a diagonal matrix are its own, exactly.
    """
    J, axes = inertia.copy(), decimals(np.eye(3))
    size = max(abs(J.ravel()))
    for _ in range(SWEEPS):
        if max(abs(J[i, j]) for i, j in combinations(range(3), 2)) < SMALLEST * size:
            break
        for i, j in combinations(range(3), 2):
            if J[i, j]:
                turn = _rotation(J, i, j)
                J, axes = turn.T @ J @ turn, axes @ turn
    order = sorted(range(3), key=lambda k: J[k, k])
    return J.diagonal()[order], axes[:, order]


def _rotation(J: Any, i: int, j: int) -> Any:
    """The plane rotation, by at most an eighth of a turn, that makes J_ij zero."""
    half = (J[j, j] - J[i, i]) / (2 * J[i, j])
    tangent = 1 / (abs(half) + (half * half + 1).sqrt()) * (1 if half >= 0 else -1)
    cosine = 1 / (tangent * tangent + 1).sqrt()
    turn = decimals(np.eye(3))
    turn[i, i] = turn[j, j] = cosine
    turn[i, j], turn[j, i] = tangent * cosine, -tangent * cosine
    return turn


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
