"""The curves of a run that kept none: its steps are repeated from checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import locate_times, refuse_outside, times_as_array
from galvi.method import Galerkin
from galvi.problem import Problem


def no_check() -> None:
    """Does nothing: the check of a run from a file, whose functions are not compared."""


# (index of a piece, rows of the times in it) -> values (rows, ...)
Evaluate = Callable[[int, Any], Array]


@dataclass(frozen=True, eq=False)
class RedoneCurves:
    """The curves that the run would have kept, computed again: identical to the bit, except that
    velocities in a clock differ by round-off.

    Attributes
    ----------
    total, steps_done
        numbers of requested and of completed steps after checkpoints[0]
    end
        the last time of the run
    checkpoints
        states of the run in the order of time, from which steps are repeated
    check
        called before steps are repeated; raises ValueError where the problem's functions have
        changed since the run
    """

    problem: Problem
    method: Galerkin
    step: float
    total: int
    steps_done: int
    end: float
    checkpoints: tuple[Checkpoint, ...]
    check: Callable[[], None] = no_check

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,); NaN after a failure.

        Raises
        ------
        ValueError
            Outside the run.
        """
        return self._values(t, "position", "positions", self.problem.q0.shape)

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, as `galvi.curves.curves.Curves.velocity`."""
        return self._values(t, "velocity", "velocities", self.problem.v0.shape)

    def _values(self, t: Any, at_times: str, in_steps: str, shape: tuple[int, ...]) -> Array:
        self.check()
        if self.method.clock is not None:
            pieces, evaluate = self._in_clock(t, at_times)
        else:
            pieces, evaluate = self._in_steps(t, in_steps)
        values = np.full((len(pieces), *shape), np.nan)
        for k in np.unique(pieces[pieces >= 0]).tolist():
            rows = np.flatnonzero(pieces == k)
            values[rows] = evaluate(k, rows)
        return values if np.ndim(t) else values[0]

    def _in_steps(self, t: Any, name: str) -> tuple[Any, Evaluate]:
        """For equal steps, the indices (k,) of the pieces between checkpoints that contain the
        times, -1 after a failure, and a function that evaluates the curves there."""
        origin = self.checkpoints[0].first
        begin = self.problem.t0 + origin * self.step
        zeros = np.broadcast_to(0.0, (self.total, 1, 1))
        index, tau, _ = locate_times(begin, self.step, zeros, t)
        is_last_end = (index == self.steps_done) & (tau == 0.0) & (index > 0)
        index, tau = np.where(is_last_end, index - 1, index), np.where(is_last_end, 1.0, tau)
        starts = np.array([state.first - origin for state in self.checkpoints])
        pieces = np.searchsorted(starts, index, side="right") - 1
        pieces[index >= self.steps_done] = -1

        def evaluate(k: int, rows: Any) -> Array:
            from galvi.run.loop import curves_of_steps  # runs stand on curves

            steps = index[rows] - starts[k]
            first, count = int(steps.min()), int(np.ptp(steps)) + 1
            curves = curves_of_steps(
                self.problem, self.method, self.step, self.checkpoints[k], first, count
            )
            return getattr(curves, name)(steps - first, tau[rows])

        return pieces, evaluate

    def _in_clock(self, t: Any, name: str) -> tuple[Any, Evaluate]:
        """As ``_in_steps``, in a clock."""
        times, _ = times_as_array(t)
        sign = 1.0 if self.step > 0.0 else -1.0
        grid = np.array([state.clock[0] for state in self.checkpoints])
        inside = (sign * times >= sign * grid[0]) & (sign * times <= sign * self.end)
        refuse_outside(inside, float(grid[0]), self.end, t)
        last = max(int(np.searchsorted(sign * grid, sign * self.end)) - 1, 0)  # before the end
        pieces = np.minimum(np.searchsorted(sign * grid, sign * times, side="right") - 1, last)

        def evaluate(k: int, rows: Any) -> Array:
            from galvi.run.loop import curves_from  # runs stand on curves

            last_needed = sign * float(np.max(sign * times[rows]))
            if last_needed == grid[k]:  # a step is needed, however short the run
                last_needed = self.end if k + 1 == len(grid) else float(grid[k + 1])
            curves = curves_from(
                self.problem, self.method, self.step, self.checkpoints[k], last_needed, self.end
            )
            return getattr(curves, name)(times[rows])

        return pieces, evaluate
