"""Distance of the Galerkin curve of one step from the exact motion between the same attitudes.

Distances as in H 3.3.3: the W^{1,1} norm over the step of the difference of xi = Phi^-1(R0^T R),
Phi the Cayley transform, by textbook formulas independent of galvi's charts.
"""

from __future__ import annotations

import numpy as np

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender

SAMPLES = 200  # of the step, for the integral
PASSES = 6
NUDGE = 1e-4


def distance(run: Trajectory, truth: Contender) -> float:
    """Integral over the first step of |xi - xi_exact| + |xi' - xi'_exact|; NaN without a motion."""
    problem, h = run.problem, run.t[1] - run.t[0]
    exact = between(problem, run.q[1], h, truth)
    if exact is None:
        return float("nan")
    t = exact.t
    xi, rate = _coordinates(problem.q0, run(t), run.velocity(t))
    known = _coordinates(problem.q0, exact.q, problem.system.velocity(exact.p))
    apart = np.linalg.norm(xi - known[0], axis=1) + np.linalg.norm(rate - known[1], axis=1)
    return float(np.trapezoid(apart, t))


def between(
    problem: Problem, last: Array, h: float, truth: Contender, samples: int = SAMPLES
) -> Trajectory | None:
    """The exact motion from q0 to ``last`` in the time h, near the one from v0; None if not found.

    By Newton's method on the initial velocity.
    """
    v = np.array(problem.v0)
    for _ in range(PASSES):
        miss = _miss(problem, v, last, h, truth)
        if not np.all(np.isfinite(miss)):
            return None
        slope = np.empty((3, 3))
        for k in range(3):
            nudge = NUDGE * np.eye(3)[k]
            ahead = _miss(problem, v + nudge, last, h, truth)
            slope[:, k] = (ahead - _miss(problem, v - nudge, last, h, truth)) / (2.0 * NUDGE)
        change = np.linalg.solve(slope, miss)
        v = v - change
        if np.max(np.abs(change)) < 1e-15:
            break
    if np.max(np.abs(_miss(problem, v, last, h, truth))) > 1e-14:
        return None
    return truth.run(_from(problem, v), h, {"samples": samples})


def _from(problem: Problem, v: Array) -> Problem:
    return Problem(problem.system, problem.q0, v, problem.t0)


def _miss(problem: Problem, v: Array, last: Array, h: float, truth: Contender) -> Array:
    """The skew part of last^T R(h), (3,)."""
    arrived = truth.run(_from(problem, v), h, {"samples": 1}).q[-1]
    S = last.T @ arrived
    return 0.5 * np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]])


def _coordinates(base: Array, R: Array, v: Array) -> tuple[Array, Array]:
    """xi with hat(xi) / 2 = (Q - 1) (Q + 1)^-1, Q = base^T R, and
    xi' = v + xi x v / 2 + (xi . v) xi / 4, for R (k, 3, 3) and body velocities v (k, 3)."""
    Q = np.einsum("ji,kjl->kil", base, R)
    A = np.linalg.solve(np.swapaxes(Q, 1, 2) + np.eye(3), np.swapaxes(Q, 1, 2) - np.eye(3))
    A = np.swapaxes(A, 1, 2)
    xi = 2.0 * np.stack([A[:, 2, 1], A[:, 0, 2], A[:, 1, 0]], axis=1)
    along = np.sum(xi * v, axis=1, keepdims=True)
    return xi, v + 0.5 * np.cross(xi, v) + 0.25 * along * xi
