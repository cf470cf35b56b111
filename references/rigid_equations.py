"""Euler's equations of a rigid body in quaternions or rotation matrices, independent of galvi's.

With w = J^-1 p:  p' = p x w + torque,  and  y' = y w / 2 for quaternions or R' = R hat(w). The
torque is that of the potential plus the external one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from galvi import Problem, RigidBody, UniformGravity
from galvi.arrays import Array
from references.forces.force import agrees, checked, derivative
from references.newton import is_forced

ATTITUDES = 8  # number of attitudes besides the start at which a user's gradient is compared


@dataclass(frozen=True, eq=False)
class RigidEquations:
    """The equations of motion of a RigidBody problem, for states (attitude, p).

    Attributes
    ----------
    quaternions
        True: attitudes are quaternions (4,), scalar first, of the rotation since the start, R = R0
        M(y / |y|); False: the nine entries of R by rows
    """

    problem: Problem
    quaternions: bool

    @property
    def start(self) -> Array:
        """The initial state, (7,) or (12,)."""
        attitude = [1.0, 0.0, 0.0, 0.0] if self.quaternions else self.problem.q0.ravel()
        return np.concatenate([attitude, self.problem.p0])

    def slope(self) -> Any:
        """The right-hand side f(t, state), in the state's shape."""
        inverse = np.linalg.inv(self.problem.system.inertia)
        attitude_slope = quaternion_slope if self.quaternions else _matrix_slope
        system, forced = self.problem.system, is_forced(self.problem)
        free = system.potential is None and not forced

        def slope(t: float, y: Array) -> Array:
            attitude, p = y[:-3], y[-3:]
            w = inverse @ p
            rates = np.array([*attitude_slope(attitude, w), *_cross(p, w)])
            if free:
                return rates
            R = self.attitudes(y)
            rates[-3:] += torque(system, R, t)
            if forced:
                arguments = (R.copy(), w.copy(), t) if system.timed_force else (R.copy(), w.copy())
                rates[-3:] += checked(system.force(*arguments), (3,))
            return rates

        return slope

    def attitudes(self, states: Array) -> Array:
        """R (..., 3, 3) of states (..., 7 or 12)."""
        if not self.quaternions:
            return states[..., :9].reshape(*states.shape[:-1], 3, 3)
        return self.problem.q0 @ rotation(states[..., :4])


def is_rigid_body(problem: Problem) -> bool:
    """Whether the problem's system is a RigidBody, with any potential and external torque."""
    return isinstance(problem.system, RigidBody)


def has_known_weight(problem: Problem) -> bool:
    """Whether the potential is a `galvi.UniformGravity`, and a user's gradient, if any, agrees with
    it at the start and at other attitudes."""
    system: Any = problem.system
    if not isinstance(system.potential, UniformGravity):
        return False
    if system.gradient is None:
        return True
    weight = replace(system, gradient=None, force=None, timed_force=False)
    with_gradient = replace(weight, gradient=system.gradient)
    turns = np.random.default_rng(0).standard_normal((ATTITUDES, 4))
    return agrees(
        lambda R: torque(with_gradient, R, 0.0),
        lambda R: torque(weight, R, 0.0),
        [problem.q0, *(problem.q0 @ rotation(turns))],
    )


def torque(system: RigidBody, R: Array, t: float) -> Array:
    """The potential's torque in the body's frame, (3,).

    By the weight, centre x R^T mass g; by a gradient, the sum over rows of R x dV/dR; else each
    component is minus the derivative of V along a rotation about its axis.
    """
    weight = system.potential
    if weight is None:
        return np.zeros(3)
    if isinstance(weight, UniformGravity) and system.gradient is None:
        return np.array(_cross(weight.centre, weight.mass * (weight.g @ R)))
    time = (t,) if system.explicit_time else ()
    if system.gradient is not None:
        slopes = checked(system.gradient(R.copy(), *time), (3, 3))
        return np.sum([_cross(row, slope) for row, slope in zip(R, slopes, strict=True)], axis=0)

    def energy(half_angle: float, axis: Array) -> float:
        y = np.array([np.cos(half_angle), *(np.sin(half_angle) * axis)])
        return float(weight(R @ rotation(y), *time))

    return -0.5 * np.array([derivative(partial(energy, axis=e), 1.0) for e in np.eye(3)])


def rotation(y: Array) -> Array:
    """The matrix (..., 3, 3) of y / |y|, y (..., 4) with the scalar first."""
    single = y.ndim == 1  # in floats, four times as fast as in arrays of one number
    w, a, b, c = y.tolist() if single else np.moveaxis(y, -1, 0)
    square = w * w + a * a + b * b + c * c
    rows = [
        [w * w + a * a - b * b - c * c, 2 * (a * b - w * c), 2 * (a * c + w * b)],
        [2 * (a * b + w * c), w * w - a * a + b * b - c * c, 2 * (b * c - w * a)],
        [2 * (a * c - w * b), 2 * (b * c + w * a), w * w - a * a - b * b + c * c],
    ]
    matrix = np.array(rows) / square
    return matrix if single else np.moveaxis(matrix, (0, 1), (-2, -1))


def quaternion_slope(y: Array, w: Array) -> tuple[float, ...]:
    """y w / 2, the product of quaternions, 4 numbers."""
    s, a, b, c = y.tolist()
    i, j, k = w.tolist()
    return (
        0.5 * (-a * i - b * j - c * k),
        0.5 * (s * i + b * k - c * j),
        0.5 * (s * j + c * i - a * k),
        0.5 * (s * k + a * j - b * i),
    )


def _matrix_slope(entries: Array, w: Array) -> list[float]:
    """R hat(w), by rows R_i x w, 9 numbers."""
    return [rate for row in entries.reshape(3, 3) for rate in _cross(row, w)]


def _cross(a: Array, b: Array) -> tuple[float, ...]:
    """a x b, 3 numbers."""
    x, y, z = a.tolist()
    i, j, k = b.tolist()
    return y * k - z * j, z * i - x * k, x * j - y * i
