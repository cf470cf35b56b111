"""The curves of a run that kept none: the steps are done again from states within the run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import located
from galvi.method import Galerkin
from galvi.problem import Problem


class CurvesOfSteps(Protocol):
    """Curves of consecutive steps."""

    def places(self, index: Any, tau: Array) -> Array:
        """q (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""

    def velocities(self, index: Any, tau: Array) -> Array:
        """dq/dt there, (k, ...)."""


@dataclass(frozen=True, eq=False)
class RedoneCurves:
    """As `Curves`, bit for bit, of ``total`` steps from known[0], of which ``done`` were done.

    known  the run before some of its steps, in their order
    """

    problem: Problem
    method: Galerkin
    step: float
    total: int
    done: int
    known: tuple[Checkpoint, ...]

    # (problem, method, step, checkpoint, n) -> the curves of n steps: registered by galvi/__init__,
    # as it does a run, which stands above.
    redo_of: ClassVar[Callable[..., CurvesOfSteps]]

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,); NaN after a failure.

        ValueError outside the run.
        """
        return self._each(t, lambda curves, index, tau: curves.places(index, tau))

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, as `Curves.velocity`."""
        return self._each(t, lambda curves, index, tau: curves.velocities(index, tau))

    def _each(self, t: Any, values: Callable[[CurvesOfSteps, Any, Array], Array]) -> Array:
        first = self.known[0].first
        begin = self.problem.t0 + first * self.step
        zeros = np.broadcast_to(0.0, (self.total, 1, 1))
        index, tau, single = located(begin, self.step, zeros, t)
        ended = (index == self.done) & (tau == 0.0) & (index > 0)
        index, tau = np.where(ended, index - 1, index), np.where(ended, 1.0, tau)
        starts = np.array([one.first - first for one in self.known])
        pieces = np.searchsorted(starts, index, side="right") - 1
        pieces[index >= self.done] = -1
        found: Array | None = None
        for k in np.unique(pieces[pieces >= 0]).tolist():
            rows = np.flatnonzero(pieces == k)
            own = index[rows] - starts[k]
            count = int(own.max()) + 1
            curves = self.redo_of(self.problem, self.method, self.step, self.known[k], count)
            some = values(curves, own, tau[rows])
            if found is None:
                found = np.full((len(index), *some.shape[1:]), np.nan)
            found[rows] = some
        if found is None:  # all after a failure, or no time at all
            found = np.full((len(index), *self.problem.q0.shape), np.nan)
        return found[0] if single else found
