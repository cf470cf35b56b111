"""A plate thrown in its plane, as the motion on SE(2) of a frame with its origin off the centre.

It rotates steadily, and its centre of mass falls on a parabola.
"""

from __future__ import annotations

import numpy as np

import galvi
from galvi import Problem
from galvi.arrays import Array
from references.compiled import njit

MASS, INERTIA = 2.0, 1.5  # about the centre
CENTRE = np.array([0.3, -0.2])  # from the frame's origin, in the frame
ASIDE = np.array([-CENTRE[1], CENTRE[0]])  # CENTRE, rotated by pi / 2
G = np.array([0.0, -1.0])
TURNING, SPEED = 1.5, np.array([0.3, 0.2])  # of the centre


@njit()
def lagrangian(q: Array, v: Array) -> float:
    """T - V for q = [[R, x], [0, 1]], (3, 3).

    The centre is at x + R CENTRE and moves, in the frame, with u = v[1:] + v[0] ASIDE.
    """
    ux, uy = v[1] + v[0] * ASIDE[0], v[2] + v[0] * ASIDE[1]
    x = q[0, 2] + q[0, 0] * CENTRE[0] + q[0, 1] * CENTRE[1]
    y = q[1, 2] + q[1, 0] * CENTRE[0] + q[1, 1] * CENTRE[1]
    kinetic = 0.5 * INERTIA * v[0] ** 2 + 0.5 * MASS * (ux * ux + uy * uy)
    return float(kinetic + MASS * (G[0] * x + G[1] * y))


@njit()
def slopes(q: Array, v: Array) -> Array:
    """dL/dv (3,), then dL/dq (9,)."""
    out = np.zeros(12)
    u = v[1:] + v[0] * ASIDE
    out[0] = INERTIA * v[0] + MASS * np.sum(u * ASIDE)
    out[1:3] = MASS * u
    for i in range(2):
        out[3 + 3 * i : 5 + 3 * i] = MASS * G[i] * CENTRE
        out[5 + 3 * i] = MASS * G[i]
    return out


def problem() -> Problem:
    """The thrown plate, its frame at I."""
    start = np.concatenate([[TURNING], SPEED - TURNING * ASIDE])
    system = galvi.Lagrangian(lagrangian, galvi.SE2(), slopes)
    return Problem(system, np.eye(3), start, name="thrown plate on SE(2)")


def end(duration: float) -> Array:
    """The exact q at `duration`, (3, 3)."""
    c, s = np.cos(TURNING * duration), np.sin(TURNING * duration)
    q = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    q[:2, 2] = CENTRE + duration * SPEED + 0.5 * duration**2 * G - q[:2, :2] @ CENTRE
    return q
