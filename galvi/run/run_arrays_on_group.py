"""The arrays that one run on a group writes into."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.groups.group import Group
from galvi.kernels.nystrom.advance import DONE
from galvi.method import Galerkin


@dataclass(frozen=True, eq=False)
class GroupWorkspace:
    """Where a run stands and what it has kept; r entries of an element, d components, s stages.

    state, stages, memo  (4, max(r, d)), (d, s), (4,), see galvi.kernels.on_group.advance
    turned               (1,) angle that the step that failed turns by
    counts               (4,) iterations, force and Hessian evaluations, linear solves
    kept                 numbers of the steps that are saved
    saved_g, saved_mu    (len(kept), r) and (len(kept), d), NaN until they are computed
    bases, coefficients  (steps, r), (steps, d, m) of the curves, or no rows
    """

    state: Array
    stages: Array
    memo: npt.NDArray[np.int64]
    turned: Array
    counts: npt.NDArray[np.int64]
    kept: list[int]
    saved_g: Array
    saved_mu: Array
    bases: Array
    coefficients: Array

    @classmethod
    def of(
        cls,
        group: Group,
        start: Checkpoint,
        method: Galerkin,
        steps: int,
        every: int,
        curves: bool,
    ) -> GroupWorkspace:
        """Room for ``steps`` steps from ``start``."""
        r, d = int(np.prod(group.shape)), group.dimension
        kept = [*range(0, steps, every), steps]
        saved_g, saved_mu = np.full((len(kept), r), np.nan), np.full((len(kept), d), np.nan)
        saved_g[0], saved_mu[0] = start.state[0, :r], start.state[1, :d]
        memo = start.memo.copy()
        memo[DONE] = 0
        rows = steps if curves else 0
        return cls(
            start.state.copy(), start.stages.copy(), memo, np.zeros(1), np.zeros(4, dtype=np.int64),
            kept, saved_g, saved_mu, np.full((rows, r), np.nan),
            np.full((rows, d, method.space.dimension - 1), np.nan),
        )  # fmt: skip

    @property
    def done(self) -> int:
        """Steps done so far."""
        return int(self.memo[DONE])
