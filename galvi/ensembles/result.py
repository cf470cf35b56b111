"""The result of an ensemble."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.outcome import Outcome


@dataclass(frozen=True, eq=False)
class Ensemble:
    """The kept values of n members, and how each ended.

    Attributes
    ----------
    kept
        arrays with the members in front; NaN for a member from its failure on
    outcomes
        number of a member -> its outcome; members without an entry completed their steps
    iterations : array, shape (n,)
        numbers of passes in all steps
    files
        a clause on the files that were loaded, computed or damaged; "" without a folder

    Notes
    -----
    ``np.asarray(result)`` is the kept array, with the members in front; several arrays are stacked
    along a second axis if they have the same shape, else concatenated as rows (members, ...).
    ``result[k]`` is the k-th of several arrays, or the row of the k-th member of a single one.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> q0 = problem.q0 + np.linspace(0.0, 0.1, 4)[:, None]
    >>> result = galvi.integrate_ensemble(problem, q0, problem.v0, method, step=0.25, steps=40)
    >>> result.members, result.status[0], np.asarray(result).shape
    (4, 'Completed.', (4, 2, 2))
    """

    kept: tuple[Array, ...]
    outcomes: dict[int, Outcome]
    iterations: Any
    files: str = ""

    def __len__(self) -> int:
        return len(self.kept) if len(self.kept) > 1 else self.members

    def __getitem__(self, k: Any) -> Array:
        return self.kept[k] if len(self.kept) > 1 else self.kept[0][k]

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        if len(self.kept) == 1:
            array = self.kept[0]
            return np.array(array, dtype=dtype, copy=copy)
        if len({part.shape for part in self.kept}) == 1:
            array = np.stack(self.kept, axis=1)
        else:
            array = np.concatenate([part.reshape(len(part), -1) for part in self.kept], axis=1)
        return array.astype(dtype, copy=False) if dtype is not None else array

    @property
    def members(self) -> int:
        """Number of members."""
        return len(self.iterations)

    @cached_property
    def failed_step(self) -> Any:
        """The number (n,) of the step that failed, from 1; 0 for none."""
        steps = np.zeros(self.members, dtype=np.int64)
        for member, outcome in self.outcomes.items():
            steps[member] = outcome.failed_step or 0
        return steps

    @cached_property
    def success(self) -> Any:
        """Whether each member completed its steps, (n,)."""
        return self.failed_step == 0

    @cached_property
    def status(self) -> tuple[str, ...]:
        """One sentence on the end of each member, with the remedy where it failed."""
        return tuple(str(self.outcomes.get(k, Outcome())) for k in range(self.members))

    def __repr__(self) -> str:
        shapes = ", ".join(str(part.shape) for part in self.kept)
        files = f"; {self.files}" if self.files else ""
        completed = int(self.success.sum())
        return f"Ensemble({self.members} members, {completed} completed: {shapes}{files})"
