"""Two bodies on pivots, joined by a spring between points off their centres, on SO(3) x SO(3).

L = sum_i (w_i . J_i w_i / 2 + WEIGHTS_i . R_i CENTRES_i) - k |y|^2 / 2 with the spring's length
y = PIVOT_GAP + R_2 HOOKS_2 - R_1 HOOKS_1, for attitudes R_i and body velocities w_i; J_i are about
the pivots.
"""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.test_problems.coupled import Coupled, NewtonEuler, cross
from galvi import Problem
from galvi.arrays import Array
from references.compiled import njit

GROUP = galvi.Product((galvi.SO3(), galvi.SO3()))
INERTIAS = np.array([np.diag([4.8, 3.0, 3.8]), np.diag([2.0, 2.4, 1.6])])
CENTRES = np.array([[0.0, 0.0, 1.0], [0.1, -0.2, 0.8]])  # from the pivots, in the bodies
HOOKS = np.array([[0.2, 0.1, 1.3], [-0.3, 0.2, 1.0]])
WEIGHTS = np.array([[0.0, 0.0, 9.81], [0.0, 0.0, 5.0]])  # m g, e3 down
PIVOT_GAP, SPRING = np.array([0.5, 0.0, 0.0]), 6.0  # of the pivots
TURNING = np.array([[0.5, -0.5, 0.4], [-0.4, 0.6, 0.3]])


@njit()
def lagrangian(q: Array, v: Array) -> float:
    """T - V of both attitudes by rows (18,) and both body velocities (6,)."""
    total, y = 0.0, PIVOT_GAP.copy()
    for i in range(2):
        R, w = np.ascontiguousarray(q[9 * i : 9 * i + 9]).reshape(3, 3), v[3 * i : 3 * i + 3]
        total += 0.5 * np.sum(w * (INERTIAS[i] @ w)) + np.sum(WEIGHTS[i] * (R @ CENTRES[i]))
        y += (2 * i - 1) * (R @ HOOKS[i])
    return float(total - 0.5 * SPRING * np.sum(y * y))


@njit()
def slopes(q: Array, v: Array) -> Array:
    """dL/dv (6,), then dL/dq (18,)."""
    out, y = np.zeros(24), PIVOT_GAP.copy()
    for i in range(2):
        R = np.ascontiguousarray(q[9 * i : 9 * i + 9]).reshape(3, 3)
        y += (2 * i - 1) * (R @ HOOKS[i])
    for i in range(2):
        out[3 * i : 3 * i + 3] = INERTIAS[i] @ v[3 * i : 3 * i + 3]
        for j in range(3):
            for k in range(3):
                weight = WEIGHTS[i, j] * CENTRES[i, k]
                out[6 + 9 * i + 3 * j + k] = weight - (2 * i - 1) * SPRING * y[j] * HOOKS[i, k]
    return out


def problem() -> Problem:
    """The two bodies, both from I."""
    system = galvi.Lagrangian(lagrangian, GROUP, slopes)
    start = GROUP.join(np.eye(3), np.eye(3))
    return Problem(system, start, TURNING.ravel(), name="two pendulums joined by a spring")


def pull(R: Array, extra: Array) -> tuple[Array, Array]:
    """Torques about the pivots (2, 3) in the bodies' frames; nothing else moves."""
    force = SPRING * (PIVOT_GAP + R[1] @ HOOKS[1] - R[0] @ HOOKS[0])
    torques = [
        cross(CENTRES[i], WEIGHTS[i] @ R[i]) + cross(HOOKS[i], (1 - 2 * i) * force @ R[i])
        for i in range(2)
    ]
    return np.array(torques), extra


def motion(q: Array, mu: Array) -> NewtonEuler:
    """The same motion by Euler's equations, from momenta (6,)."""
    return NewtonEuler(INERTIAS, np.array(GROUP.parts(q)), mu.reshape(2, 3), np.zeros(0), pull)


def state(R: Array, turning: Array, extra: Array) -> tuple[Array, Array]:
    """(q, mu) of attitudes (2, 3, 3) and angular momenta (2, 3)."""
    return R.reshape(18).astype(float), turning.reshape(6).astype(float)


JOINED_PENDULUMS = Coupled(problem, motion, state)
