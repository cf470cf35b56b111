"""Where a run stands, to the bit: what the next step needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.groups.so3 import SO3
from galvi.kernels.nystrom.advance import GUESS, NOTHING
from galvi.problem import Problem


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A run after ``first`` steps from the problem's start.

    first      steps done so far, so that times are t0 + k h in every part of a run
    state      (4, d) q, what rounding lost of q, v, what rounding lost of v; on a group see
               galvi.kernels.lanes.body
    stages     (d, s) accelerations, on a group velocities, at the last step's stages, from which
               the next is predicted
    memo       the kernels' memory, see galvi.kernels.nystrom.advance, .packed and .group_advance
    solver     "auto", "fixed_point" or "newton"
    tolerance  relative change at which a step's iteration stops
    """

    first: int
    state: Array
    stages: Array
    memo: npt.NDArray[np.int64]
    solver: str
    tolerance: float

    @classmethod
    def at_start(cls, problem: Problem, stages: int, solver: str, tolerance: float) -> Checkpoint:
        """Before the first step."""
        state = np.zeros((4, problem.q0.size))
        state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
        a = np.zeros((problem.q0.size, stages))
        blocks = problem.q0.size // problem.q0.shape[-1]
        memo = np.array([NOTHING, 0, 0] + [0] * blocks, dtype=np.int64)
        return cls(0, state, a, memo, solver, tolerance)

    @classmethod
    def on_group(cls, problem: Problem, stages: int, solver: str, tolerance: float) -> Checkpoint:
        """On a group, the state's rows are g, mu and what rounding lost; stages are velocities.

        Of a body that turns, the second row ends in its momentum in space, R mu.
        """
        p0, entries = problem.p0, problem.q0.size
        state = np.zeros((4, max(entries, p0.size)))
        state[0, :entries], state[1, : p0.size] = problem.q0.ravel(), p0
        if isinstance(getattr(problem.system, "group", None), SO3):
            state[1, 6:] = problem.q0 @ p0
        velocities = np.repeat(problem.v0[:, None], stages, axis=1)
        memo = np.array([GUESS, 0, 0, 0], dtype=np.int64)
        return cls(0, state, velocities, memo, solver, tolerance)
