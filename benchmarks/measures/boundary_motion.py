"""Distance of the Galerkin curve of one step from the exact motion between the same two points.

Distances are in W^{1,1} of the step, the integral of |q - q_exact| + |q' - q'_exact| (H 2.3.4), and
in L^infinity, the largest |q - q_exact|.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import simpson

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender

SAMPLES = 200  # of the step, for the integral
PASSES = 20
NUDGE = 1e-4
MISSED = 2e-15  # of points of size 1; the truth is rounded to 2e-16


@dataclass(frozen=True, eq=False)
class BoundaryValueMotion:
    """Exact motions of duration ``step`` from a problem's q0, parametrised by initial velocity."""

    problem: Problem
    step: float
    truth: Contender

    def distances(self, run: Trajectory) -> tuple[float, float]:
        """Distances of a run's first step from the motion to the same point, in W^{1,1} and
        L^infinity; NaN where no motion was found."""
        exact = self.arriving_at(run.q[1])
        if exact is None:
            return float("nan"), float("nan")
        velocity = self.problem.system.velocity(exact.p)
        gap, rate = run(exact.t) - exact.q, run.velocity(exact.t) - velocity
        apart, moving = np.linalg.norm(gap, axis=1), np.linalg.norm(rate, axis=1)
        return float(np.trapezoid(apart + moving, exact.t)), float(np.max(apart))

    def square_of_rates(self, run: Trajectory) -> float:
        """Integral of |q' - q'_exact|^2 over a run's first step and the motion to the same point:
        M's |q - q_exact|_X^2 where both ends are met; NaN where no motion was found."""
        exact = self.arriving_at(run.q[1])
        if exact is None:
            return float("nan")
        rate = run.velocity(exact.t) - self.problem.system.velocity(exact.p)
        return float(simpson(np.sum(rate * rate, axis=1), x=exact.t))

    def error(self, run: Trajectory) -> float:
        """Largest component by which a run's first step misses the motion from v0."""
        return float(np.max(np.abs(run.q[1] - self.end)))

    def arriving_at(self, last: Array) -> Trajectory | None:
        """The motion to ``last`` that is near the one from v0, by Broyden's method, or None."""
        v, gap, slope = np.array(self.problem.v0), self.end - last, self.slope
        for _ in range(PASSES):
            if np.max(np.abs(gap)) <= MISSED:
                return self.truth.run(self._from(v), self.step, {"samples": SAMPLES})
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
        """Derivative of the end by the initial velocity at v0, (d, d), by central differences."""
        nudges = NUDGE * np.eye(self.problem.v0.size)
        v = self.problem.v0
        return np.stack(
            [(self._end_from(v + e) - self._end_from(v - e)) / (2.0 * NUDGE) for e in nudges],
            axis=1,
        )

    def _end_from(self, v: Array) -> Array:
        arrived: Array = self.truth.run(self._from(v), self.step, {"samples": 1}).q[-1]
        return arrived

    def _from(self, v: Array) -> Problem:
        return Problem(self.problem.system, self.problem.q0, v, self.problem.t0)
