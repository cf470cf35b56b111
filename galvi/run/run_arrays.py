"""The arrays that one run writes into."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.kernels.nystrom.advance import DONE
from galvi.method import Galerkin
from galvi.problem import Problem


def check_memory(
    problems: Sequence[Problem], method: Galerkin, steps: int, save_every: int, curves: bool | None
) -> None:
    """ValueError when what a run of each problem would keep is more than this machine's memory."""
    d, m = sum(problem.q0.size for problem in problems), method.space.dimension - 1
    with_curves = save_every == 1 if curves is None else curves
    rows = 2 * (steps / save_every + 2) + (steps * (1 + m) if with_curves else 0)
    needed = 8.0 * d * rows
    if not hasattr(os, "sysconf"):
        return
    memory = float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    if needed > memory:
        runs = f"{len(problems)} runs of " if len(problems) > 1 else ""
        raise ValueError(
            f"{runs}{steps} steps would keep {needed / 2**30:.3g} GiB in all, more than the "
            f"{memory / 2**30:.3g} GiB of this machine. Keep fewer with save_every, and "
            f"curves=False."
        )


@dataclass(frozen=True, eq=False)
class Workspace:
    """Where a run stands and what it has kept; d components, s stages, m curve coefficients.

    state, stages, memo  (4, d), (d, s), (3 + blocks,), see galvi.checkpoint
    counts               (5,) iterations, force and Hessian evaluations, linear solves, single pairs
    kept                 numbers of the steps that are saved
    saved                (2, len(kept), d) positions and velocities, NaN until they are computed
    bases, coefficients  (steps, d), (steps, d, m) of the curves, or no rows
    """

    state: Array
    stages: Array
    memo: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]
    kept: list[int]
    saved: Array
    bases: Array
    coefficients: Array

    @classmethod
    def of(
        cls, start: Checkpoint, method: Galerkin, steps: int, save_every: int, curves: bool
    ) -> Workspace:
        """Room for ``steps`` steps from ``start``."""
        d, m = start.state.shape[1], method.space.dimension - 1
        kept = [*range(0, steps, save_every), steps]
        saved = np.full((2, len(kept), d), np.nan)
        saved[0, 0], saved[1, 0] = start.state[0], start.state[2]
        memo = start.memo.copy()
        memo[DONE] = 0
        rows = steps if curves else 0
        return cls(
            start.state.copy(), start.stages.copy(), memo, np.zeros(5, dtype=np.int64), kept, saved,
            np.full((rows, d), np.nan), np.full((rows, d, m), np.nan),
        )  # fmt: skip

    @property
    def done(self) -> int:
        """Steps done so far."""
        return int(self.memo[DONE])
