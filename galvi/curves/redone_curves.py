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

    # (problem, method, step, checkpoint, k, n) -> the curves of n steps after k: registered by
    # galvi/__init__, as it does a run, which stands above.
    redo_of: ClassVar[Callable[..., CurvesOfSteps]]

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,); NaN after a failure.

        ValueError outside the run.
        """
        shape = self.problem.q0.shape
        return self._each(t, shape, lambda curves, index, tau: curves.places(index, tau))

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, as `Curves.velocity`."""
        shape = self.problem.v0.shape
        return self._each(t, shape, lambda curves, index, tau: curves.velocities(index, tau))

    def _each(
        self, t: Any, shape: tuple[int, ...], values: Callable[[CurvesOfSteps, Any, Array], Array]
    ) -> Array:
        origin = self.known[0].first
        begin = self.problem.t0 + origin * self.step
        zeros = np.broadcast_to(0.0, (self.total, 1, 1))
        index, tau, single = located(begin, self.step, zeros, t)
        ended = (index == self.done) & (tau == 0.0) & (index > 0)
        index, tau = np.where(ended, index - 1, index), np.where(ended, 1.0, tau)
        starts = np.array([one.first - origin for one in self.known])
        pieces = np.searchsorted(starts, index, side="right") - 1
        pieces[index >= self.done] = -1
        found = np.full((len(index), *shape), np.nan)
        for k in np.unique(pieces[pieces >= 0]).tolist():
            rows = np.flatnonzero(pieces == k)
            own = index[rows] - starts[k]
            first, count = int(own.min()), int(own.max() - own.min()) + 1
            curves = self.redo_of(self.problem, self.method, self.step, self.known[k], first, count)
            found[rows] = values(curves, own - first, tau[rows])
        return found[0] if single else found
