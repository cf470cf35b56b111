"""A 3D pendulum on a cart with a spring, on SO(3) x R, with a coupled kinetic energy.

L = w . J w / 2 + m x'^2 / 2 + x' w . (c x R^T e1) - k x^2 / 2 + W e3 . R c,  velocities (w, x').
"""

from __future__ import annotations

import numpy as np

import galvi
from galvi import Problem
from galvi.arrays import Array
from references.compiled import njit

GROUP = galvi.Product((galvi.SO3(), galvi.Rn(1)))
INERTIA = np.diag([4.8, 3.0, 3.8])
CENTRE = np.array([0.1, -0.2, 0.8])
MASS, SPRING, WEIGHT = 3.0, 2.0, 9.81


@njit()
def lagrangian(q: Array, v: Array) -> float:
    """L of (R by rows, x) and (w, x')."""
    w, rate = v[:3], v[3]
    kinetic = 0.5 * MASS * rate**2 + rate * np.sum(w * np.cross(CENTRE, q[:3]))
    kinetic += 0.5 * np.sum(w * (INERTIA @ w))
    return float(kinetic - 0.5 * SPRING * q[9] ** 2 + WEIGHT * np.sum(q[6:9] * CENTRE))


@njit()
def slopes(q: Array, v: Array) -> Array:
    """dL/dv, then dL/dq by rows, (14,)."""
    w, rate = v[:3], v[3]
    arm = np.cross(CENTRE, q[:3])
    out = np.zeros(14)
    out[:3] = INERTIA @ w + rate * arm
    out[3] = MASS * rate + np.sum(w * arm)
    out[4:7] = rate * np.cross(w, CENTRE)
    out[10:13] = WEIGHT * CENTRE
    out[13] = -SPRING * q[9]
    return out


def body_on_cart() -> Problem:
    """The body on a cart, started with velocities in all directions."""
    start = GROUP.join(np.eye(3), np.array([0.3]))
    return Problem(
        galvi.Lagrangian(lagrangian, GROUP, slopes),
        start,
        [0.5, -0.5, 0.4, -0.2],
        name="body on a cart",
    )
