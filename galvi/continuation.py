"""Where a run stands, to the bit: what the next step needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.kernels.advance import NOTHING
from galvi.problem import Problem


@dataclass(frozen=True, eq=False)
class Continuation:
    """A run after ``first`` steps from the problem's start.

    first      steps done so far, so that times are t0 + k h in every part of a run
    state      (4, d) q, what rounding lost of q, v, what rounding lost of v
    stages     (d, s) accelerations at the last step's stages, from which the next is predicted
    memo       (3 + bodies,) the kernels' memory, see galvi.kernels.advance and .packed
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
    def at_start(cls, problem: Problem, stages: int, solver: str, tolerance: float) -> Continuation:
        """Before the first step."""
        state = np.zeros((4, problem.q0.size))
        state[0], state[2] = problem.q0.ravel(), problem.v0.ravel()
        a = np.zeros((problem.q0.size, stages))
        blocks = problem.q0.size // problem.q0.shape[-1]
        memo = np.array([NOTHING, 0, 0] + [0] * blocks, dtype=np.int64)
        return cls(0, state, a, memo, solver, tolerance)
