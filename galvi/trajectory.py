"""What a run leaves behind: times, states, why it ended, what it cost, and its curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves
from galvi.problem import Problem

if TYPE_CHECKING:
    import pandas

COMPLETED = "Completed."


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of one problem at increasing (or, for a negative step, decreasing) times.

    problem       what was integrated
    t             (saved,) times
    q, p          (saved, ...) configurations and conjugate momenta; NaN past a failure
    success       whether every step was done
    status        a sentence saying why the run ended
    failed_step   number of the first step that was not done, counted from 1; None on success
    counts        steps, iterations, force_evaluations, hessian_evaluations, linear_solves, and
                  for N bodies pair_evaluations, which include passes over two bodies alone
    step          the step size; None for a reference with steps of its own
    method        the method or reference that made it
    curves        the Galerkin curve of each step; None when not kept
    checkpoint    what `galvi.resume` needs; None for references
    interrupted   whether Ctrl-C ended it; it can be resumed
    """

    problem: Problem
    t: Array
    q: Array
    p: Array
    success: bool = True
    status: str = COMPLETED
    failed_step: int | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    step: float | None = None
    method: Any = None
    curves: Curves | None = None
    checkpoint: Checkpoint | None = None
    interrupted: bool = False

    def __call__(self, t: Any) -> Array:
        """Configuration on the curve at t: shape (...) for a scalar, (k, ...) for t of shape (k,).

        Raises ValueError when t is outside the run or the curves were not kept. Past a failure the
        curve is NaN.
        """
        return self._kept_curves().position(t)

    def velocity(self, t: Any) -> Array:
        """Velocity of the curve at t: dq/dt, or on a group the body's; errors as for a call."""
        return self._kept_curves().velocity(t)

    def to_frame(self) -> pandas.DataFrame:
        """A tidy pandas frame: t, then one column for each component of q and of p."""
        import pandas

        def columns(name: str, states: Array) -> dict[str, Array]:
            flat = states.reshape(len(states), -1)
            labels = [",".join(map(str, index)) for index in np.ndindex(states.shape[1:])]
            return {f"{name}[{label}]": flat[:, k] for k, label in enumerate(labels)}

        return pandas.DataFrame({"t": self.t, **columns("q", self.q), **columns("p", self.p)})

    def _kept_curves(self) -> Curves:
        if self.curves is None:
            raise ValueError(
                "this run has no curves to evaluate; integrate with curves=True or save_every=1 "
                "(references keep none)."
            )
        return self.curves

    def __repr__(self) -> str:
        return (
            f"Trajectory({self.problem.name or 'problem'}, t = {self.t[0]:g} to {self.t[-1]:g}, "
            f"{len(self.t)} states, {self.status})"
        )
