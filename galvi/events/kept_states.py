"""The states, checkpoints and curves that a run in blocks saves."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import JoinedCurves, first_steps, merge_curves
from galvi.curves.redone_curves import RedoneCurves
from galvi.run.request import RunRequest
from galvi.run.same_functions import SameFunctions
from galvi.run.states import saved_velocities
from galvi.trajectory import Restarts, Trajectory


class KeptStates:
    """The record of a run in blocks.

    Attributes
    ----------
    begin
        time of the first state
    checkpoints
        states from which the curves can be computed again
    curves
        pairs of the time at which a part begins and its curves
    restarts
        t, q and v after each action
    """

    def __init__(self, request: RunRequest) -> None:
        self.request = request
        first: Any = request.continues
        states = [getattr(request.problem, name) for name in ("t0", "q0", "p0", "v0")]
        if first is not None:
            states = [array[-1] for array in (first.t, first.q, first.p, first.v)]
        self._rows: list[tuple[Array, ...]] = []
        self.add(0.0, *states)
        self.begin = float(states[0])
        self.checkpoints: list[Checkpoint] = []
        self.curves: list[tuple[float, Any]] = []
        self.restarts: list[tuple[float, Array, Array]] = []

    def add(self, number: float, *state: Any) -> None:
        """A state t, q, p, v after a number of steps."""
        self._rows.append(tuple(np.asarray(x)[None] for x in (number, *state)))

    def add_part(self, part: Trajectory, steps_done: int) -> None:
        """States of a part after its first, which has ``steps_done`` steps before it."""
        numbers = np.arange(1, len(part.t))
        wanted = (steps_done + numbers) % self.request.checkpoint.save_every == 0
        rows = numbers[wanted | (numbers == len(numbers))]
        states = part.t[rows], part.q[rows], part.p[rows], saved_velocities(part, rows)
        self._rows.append((steps_done + rows, *states))

    def cut(self, n: int) -> None:
        """Drop the curves of the last part after its first n steps."""
        if self.curves:
            begin, curves = self.curves[-1]
            self.curves[-1] = begin, first_steps(curves, n)

    def states(self) -> list[Array]:
        """Numbers of completed steps, t, q, p and v of the saved states, with the last state."""
        arrays = [np.concatenate(x) for x in zip(*self._rows, strict=True)]
        rows = np.flatnonzero(
            np.append(arrays[0][:-1] % self.request.checkpoint.save_every == 0, True)
        )
        return [array[rows] for array in arrays]

    def all_restarts(self) -> Restarts | None:
        """The states after the actions; None without actions."""
        if not self.restarts:
            return None
        return Restarts(*(np.array(x) for x in zip(*self.restarts, strict=True)))

    def joined_curves(self, last: float) -> Any:
        """The curves of a run that ended at the time ``last``; None where they are not kept."""
        parts = [part for _, part in self.curves]
        if not parts or not self.restarts:
            return merge_curves(parts) if parts else None
        times = np.array([self.begin, *(begin for begin, _ in self.curves[1:]), last])
        return JoinedCurves(read_only(times), tuple(parts))

    def curves_again(
        self, steps: int, last: float, states: tuple[Array, Array, Array]
    ) -> RedoneCurves:
        """The curves of ``steps`` steps until time ``last``, computed again when evaluated;
        ``states`` are the saved q, p and t."""
        problem, method, step = self.request[:3]
        check = SameFunctions(problem, *states, cast(Any, method.clock), False)
        checkpoints = tuple(self.checkpoints)
        return RedoneCurves(problem, method, step, steps, steps, last, checkpoints, check)
