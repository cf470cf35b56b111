"""Interface of the two engines: runs on vector spaces and runs on Lie groups."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.local_chart import LocalChart
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.run_arrays import RunArrays
from galvi.trajectory import Trajectory

Call = Callable[[int], int]  # does n more steps; returns 0, or the code of a step that failed
Stepper = Callable[[Problem, Galerkin, float, int, Checkpoint, RunArrays], Call]
Start = tuple[Array, Array, npt.NDArray[np.int64]]


def fixed(*start: Any) -> Start:
    """The same arrays, not writeable."""
    return cast(Start, tuple(read_only(array) for array in start))


class Substeps(Protocol):
    """A run with smaller steps, which are not retried when they fail."""

    def __call__(
        self, problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint
    ) -> Trajectory:
        """The run of ``steps`` steps from ``start``."""


@dataclass(frozen=True)
class Engine:
    """The functions that differ between runs on vector spaces and on groups.

    There are two values, `NYSTROM` and `ON_GROUP`.

    start                (problem, stages) -> state, stages and solver_state before the first step,
                         see `Checkpoint`; the same arrays for each run, which copies them
    velocity_row         row of the state that is saved with q: velocities or momenta
    solves_by_iteration  (problem, method) -> whether the solver fixed_point is available
    is_compiled          (problem, method) -> whether its kernel is compiled, so that other threads
                         can run at the same time
    stepper              (problem, method, step, steps, start, arrays) -> `Call`
    stepper_from_guess   as ``stepper``, for a step that starts from a given guess
    guess_from_substeps  (substeps, problem, method, step, start, arrays) -> a guess (d, s) of the
                         next step's stages from smaller steps, or None
    guess_kind           the kernels' code for the kind of that guess
    momenta              (problem, saved_v) -> conjugate momenta, (saved, ...)
    local_chart          (problem, method) -> chart of the coordinates of its curves
    failure              (problem, method, step, code, solver, arrays) -> text: why the next step
                         failed, and the remedy
    """

    start: Callable[[Problem, int], Start]
    velocity_row: int
    solves_by_iteration: Callable[[Problem, Galerkin], bool]
    is_compiled: Callable[[Problem, Galerkin], bool]
    stepper: Stepper
    stepper_from_guess: Stepper
    guess_from_substeps: Callable[
        [Substeps, Problem, Galerkin, float, Checkpoint, RunArrays], Array | None
    ]
    guess_kind: int
    momenta: Callable[[Problem, Array], Array]
    local_chart: Callable[[Problem, Galerkin], LocalChart]
    failure: Callable[[Problem, Galerkin, float, int, str, RunArrays], str]
