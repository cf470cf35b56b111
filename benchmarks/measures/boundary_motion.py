"""Motions between given ends, and distances of curves from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import simpson

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender

# Distance of the Galerkin curve of one step from the exact motion between the same two points.
#
# Distances are in W^{1,1} of the step, the integral of |q - q_exact| + |q' - q'_exact| (H 2.3.4),
# and in L^infinity, the largest |q - q_exact|.

STEP_SAMPLES = 200  # of the step, for the integral
MOST_BROYDEN_STEPS = 20
IN_N, IN_H = "n-refinement, one step", "h-refinement, one step"
ENDS, CURVE = "error of one step", "distance of the curve in W^{1,1}"
VELOCITY_CHANGE = 1e-4
ARRIVAL_TOLERANCE = 2e-15  # of points of size 1; the truth is rounded to 2e-16


@dataclass(frozen=True, eq=False)
class BoundaryValueMotion:
    """Exact motions of duration ``step`` from a problem's q0, parametrised by initial velocity."""

    problem: Problem
    step: float
    truth: Contender

    def distances(self, run: Trajectory) -> tuple[float, float]:
        """Distances of a run's first step from the motion to the same point, in W^{1,1} and
        L^infinity; NaN where none is found."""
        exact = self.arriving_at(run.q[1])
        if exact is None:
            return float("nan"), float("nan")
        velocity = self.problem.system.velocity(exact.p)
        gap, velocity_gap = run(exact.t) - exact.q, run.velocity(exact.t) - velocity
        gap_norm, velocity_norm = np.linalg.norm(gap, axis=1), np.linalg.norm(velocity_gap, axis=1)
        return float(np.trapezoid(gap_norm + velocity_norm, exact.t)), float(np.max(gap_norm))

    def square_of_rates(self, run: Trajectory) -> float:
        """Integral of |q' - q'_exact|^2 over a run's first step and the motion to the same point:
        M's |q - q_exact|_X^2 where both ends are met; NaN where no motion was found."""
        exact = self.arriving_at(run.q[1])
        if exact is None:
            return float("nan")
        velocity_gap = run.velocity(exact.t) - self.problem.system.velocity(exact.p)
        return float(simpson(np.sum(velocity_gap * velocity_gap, axis=1), x=exact.t))

    def error(self, run: Trajectory) -> float:
        """Largest component of the error of a run's first step against the motion from v0."""
        return float(np.max(np.abs(run.q[1] - self.end)))

    def arriving_at(self, last: Array) -> Trajectory | None:
        """The motion to ``last`` that Broyden's method finds from v0; None where it does not
        converge."""
        v, gap, slope = np.array(self.problem.v0), self.end - last, self.slope
        for _ in range(MOST_BROYDEN_STEPS):
            if np.max(np.abs(gap)) <= ARRIVAL_TOLERANCE:
                return self.truth.run(self._from(v), self.step, {"samples": STEP_SAMPLES})
            change = -np.linalg.solve(slope, gap)
            if not np.all(np.isfinite(change)) or not np.any(change):
                return None
            v = v + change
            gap = self._end_from(v) - last
            slope = slope + np.outer(gap, change) / (change @ change)
        return None

    @cached_property
    def end(self) -> Array:
        """The end of the motion from v0, (d,)."""
        return self._end_from(self.problem.v0)

    @cached_property
    def slope(self) -> Array:
        """Derivative of the end by the initial velocity, at v0, (d, d), by central differences."""
        nudges = VELOCITY_CHANGE * np.eye(self.problem.v0.size)
        v = self.problem.v0
        return np.stack(
            [
                (self._end_from(v + e) - self._end_from(v - e)) / (2.0 * VELOCITY_CHANGE)
                for e in nudges
            ],
            axis=1,
        )

    def _end_from(self, v: Array) -> Array:
        return self.truth.run(self._from(v), self.step, {"samples": 1}).q[-1]

    def _from(self, v: Array) -> Problem:
        return Problem(self.problem.system, self.problem.q0, v, self.problem.t0)


# Distance of the Galerkin curve of one step from the exact motion between the same attitudes.
#
# Distances as in H 3.3.3: the W^{1,1} norm over the step of the difference of xi = Phi^-1(R0^T R),
# Phi the Cayley transform, by textbook formulas independent of galvi's charts.

MOST_NEWTON_STEPS = 6


def distance(run: Trajectory, truth: Contender) -> float:
    """Integral over the first step of |xi - xi_exact| + |xi' - xi'_exact|; NaN without a motion."""
    problem, h = run.problem, run.t[1] - run.t[0]
    exact = between(problem, run.q[1], h, truth)
    if exact is None:
        return float("nan")
    t = exact.t
    xi, rate = _coordinates(problem.q0, run(t), run.velocity(t))
    xi_exact, rate_exact = _coordinates(problem.q0, exact.q, problem.system.velocity(exact.p))
    integrand = np.linalg.norm(xi - xi_exact, axis=1) + np.linalg.norm(rate - rate_exact, axis=1)
    return float(np.trapezoid(integrand, t))


def between(
    problem: Problem, last: Array, h: float, truth: Contender, samples: int = STEP_SAMPLES
) -> Trajectory | None:
    """The exact motion from q0 to ``last`` in the time h that Newton's method finds from v0; None
    where it does not converge."""
    v = np.array(problem.v0)
    for _ in range(MOST_NEWTON_STEPS):
        miss = _miss(problem, v, last, h, truth)
        if not np.all(np.isfinite(miss)):
            return None
        slope = np.empty((3, 3))
        for k in range(3):
            nudge = VELOCITY_CHANGE * np.eye(3)[k]
            ahead = _miss(problem, v + nudge, last, h, truth)
            slope[:, k] = (ahead - _miss(problem, v - nudge, last, h, truth)) / (
                2.0 * VELOCITY_CHANGE
            )
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
    end = truth.run(_from(problem, v), h, {"samples": 1}).q[-1]
    S = last.T @ end
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
