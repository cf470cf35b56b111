"""A thrown body described by its attitude and a point off its centre, on SO(3) x R^3, or on SE(3).

The factors are coupled, but the motion is known: the attitude is that of a free body, and the
centre of mass moves on a parabola.
"""

from __future__ import annotations

import numpy as np

import galvi
from galvi import Problem, RigidBody
from galvi.arrays import Array
from references.closed_forms.top_motion import FREE_TOP
from references.compiled import njit

MASS = 2.0
INERTIA = np.diag([1.0, 2.0, 2.8])  # about the centre
POINT = np.array([0.3, -0.2, 0.5])  # from the centre, in the body's frame
G = np.array([0.0, 0.0, -1.0])
TURNING, SPEED = (0.3, 1.5, 0.4), (0.3, 0.2, -0.1)  # tumbling about the middle axis; of the centre
GROUP = galvi.Product((galvi.SO3(), galvi.Rn(3)))


@njit()
def lagrangian(q: Array, v: Array) -> float:
    """T - V for q = (R by rows, position y of the point), v = (w, y'); the centre is y - R POINT.

    The centre moves with u = y' - R (w x POINT).
    """
    R, w = np.ascontiguousarray(q[:9]).reshape(3, 3), v[:3]
    u = v[3:] - R @ np.cross(w, POINT)
    return float(
        0.5 * np.sum(w * (INERTIA @ w))
        + 0.5 * MASS * np.sum(u * u)
        + MASS * np.sum(G * (q[9:] - R @ POINT))
    )


@njit()
def slopes(q: Array, v: Array) -> Array:
    """dL/dv (6,), then dL/dq (12,)."""
    out = np.empty(18)
    R, w = np.ascontiguousarray(q[:9]).reshape(3, 3), v[:3]
    arm = np.cross(w, POINT)
    u = v[3:] - R @ arm
    out[:3] = INERTIA @ w - MASS * np.cross(POINT, R.T @ u)
    out[3:6] = MASS * u
    for i in range(3):
        for j in range(3):
            out[6 + 3 * i + j] = -MASS * (u[i] * arm[j] + G[i] * POINT[j])
    out[15:] = MASS * G
    return out


def problem() -> Problem:
    """The thrown body, from attitude I with the centre at 0."""
    turning = np.array(TURNING)
    start = GROUP.join(np.eye(3), POINT)
    v = np.concatenate([turning, np.array(SPEED) + np.cross(turning, POINT)])
    system = galvi.Lagrangian(lagrangian, GROUP, slopes)
    return Problem(system, start, v, name="thrown body, a point off its centre")


def end(duration: float) -> Array:
    """q at `duration`, (12,)."""
    attitude, centre = falling(duration)
    return GROUP.join(attitude, centre + attitude @ POINT)


def problem_by_centre() -> Problem:
    """The same body on SE(3), its frame at the centre."""
    system = galvi.FreeBody(MASS, INERTIA, G)
    return Problem(system, np.eye(4), np.array([*TURNING, *SPEED]), name="thrown body on SE(3)")


def end_by_centre(duration: float) -> Array:
    """q at `duration`, (4, 4)."""
    q = np.eye(4)
    q[:3, :3], q[:3, 3] = falling(duration)
    return q


def falling(duration: float) -> tuple[Array, Array]:
    """Attitude (3, 3) and centre (3,) at `duration`."""
    free = Problem(RigidBody(INERTIA), np.eye(3), np.array(TURNING))
    attitude = FREE_TOP.run(free, duration, {"samples": 1}).q[-1]
    return attitude, np.array(SPEED) * duration + 0.5 * G * duration**2
