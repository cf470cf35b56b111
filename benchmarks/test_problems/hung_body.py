"""A body hung by a spring from a point off its centre, on SE(3), by a frame off its centre.

L = w . J w / 2 + m |u|^2 / 2 - k |y|^2 / 2 + m g . x_c  for q = [[R, x], [0, 1]], velocities (w, v)
in the frame, with the centre's velocity u = v + w x CENTRE in the frame, its position
x_c = x + R CENTRE, and the spring, of no length at rest, from the origin to y = x + R HOOK.
Rotation and translation are coupled in T, in V, and by the coadjoint term m u x v of the momentum,
which is 0 where the frame's origin is the centre.
"""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.test_problems.coupled import Coupled, NewtonEuler, cross
from galvi import Problem
from galvi.arrays import Array
from references.compiled import njit

MASS, SPRING = 2.0, 8.0
INERTIA = np.diag([1.0, 2.0, 2.8])  # about the centre; L is of its diagonal alone
CENTRE, HOOK = np.array([0.1, -0.2, 0.3]), np.array([0.4, -0.1, 0.7])  # in the frame
G = np.array([0.0, 0.0, -1.0])
TURNING, SPEED = np.array([0.3, 1.5, 0.4]), np.array([0.3, 0.2, -0.1])  # of the centre


@njit()
def lagrangian(q: Array, v: Array) -> float:
    """T - V of a configuration (4, 4) and (w, v)."""
    twice = weight = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        u = v[3 + i] + v[j] * CENTRE[k] - v[k] * CENTRE[j]
        y = q[i, 3] + q[i, 0] * HOOK[0] + q[i, 1] * HOOK[1] + q[i, 2] * HOOK[2]
        centre = q[i, 3] + q[i, 0] * CENTRE[0] + q[i, 1] * CENTRE[1] + q[i, 2] * CENTRE[2]
        twice += INERTIA[i, i] * v[i] * v[i] + MASS * u * u - SPRING * y * y
        weight += MASS * G[i] * centre
    return 0.5 * twice + weight


@njit()
def slopes(q: Array, v: Array) -> Array:
    """dL/dv (6,), then dL/dq (16,)."""
    out = np.zeros(22)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[3 + i] = MASS * (v[3 + i] + v[j] * CENTRE[k] - v[k] * CENTRE[j])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = INERTIA[i, i] * v[i] + CENTRE[j] * out[3 + k] - CENTRE[k] * out[3 + j]
        y = q[i, 3] + q[i, 0] * HOOK[0] + q[i, 1] * HOOK[1] + q[i, 2] * HOOK[2]
        for n in range(3):
            out[6 + 4 * i + n] = MASS * G[i] * CENTRE[n] - SPRING * y * HOOK[n]
        out[9 + 4 * i] = MASS * G[i] - SPRING * y
    return out


def problem() -> Problem:
    """The hung body, its frame at I."""
    start = np.concatenate([TURNING, SPEED - np.cross(TURNING, CENTRE)])
    system = galvi.Lagrangian(lagrangian, galvi.SE3(), slopes)
    return Problem(system, np.eye(4), start, name="body hung by a spring on SE(3)")


def pull(R: Array, extra: Array) -> tuple[Array, Array]:
    """Torque about the centre (1, 3) in the body's frame; (u, force / m) for extra = (x, u)."""
    arm = HOOK - CENTRE
    force = -SPRING * (extra[:3] + R[0] @ arm)
    return cross(arm, force @ R[0])[None], np.concatenate([extra[3:], force / MASS + G])


def motion(q: Array, mu: Array) -> NewtonEuler:
    """The same motion by Newton's and Euler's equations about the centre, from momenta (6,)."""
    R, u = q[:3, :3], mu[3:] / MASS
    turning = mu[:3] - cross(CENTRE, mu[3:])
    extra = np.concatenate([q[:3, 3] + R @ CENTRE, R @ u])
    return NewtonEuler(INERTIA[None], R[None], turning[None], extra, pull)


def state(R: Array, turning: Array, extra: Array) -> tuple[Array, Array]:
    """(q, mu) of attitudes (1, 3, 3), angular momenta (1, 3) and (position, velocity) (6,)."""
    q, momentum = np.eye(4), MASS * (extra[3:] @ R[0])
    q[:3, :3], q[:3, 3] = R[0], extra[:3] - R[0] @ CENTRE
    return q, np.concatenate([turning[0] + cross(CENTRE, momentum), momentum]).astype(float)


HUNG_BODY = Coupled(problem, motion, state)
