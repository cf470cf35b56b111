"""What differs between a run on a vector space and one on a Lie group."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.local_chart import LocalChart
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.run_arrays import RunArrays
from galvi.trajectory import Trajectory

Call = Callable[[int], int]  # does so many more steps; 0, or the code of one that failed
Stepper = Callable[[Problem, Galerkin, float, int, Checkpoint, RunArrays], Call]
Start = tuple[Array, Array, npt.NDArray[np.int64]]


class Substeps(Protocol):
    """A run with smaller steps, none of which is tried again when it fails."""

    def __call__(
        self, problem: Problem, method: Galerkin, step: float, steps: int, start: Checkpoint
    ) -> Trajectory:
        """The run of ``steps`` steps from ``start``."""


@dataclass(frozen=True)
class Engine:
    """One way to run; there are two values, `NYSTROM` and `ON_GROUP`.

    start                (problem, stages) -> state, stages and solver_state before the first step,
                         see `Checkpoint`
    velocity_row         row of the state that is saved beside q: velocities or momenta
    solves_by_iteration  (problem, method) -> whether the solver fixed_point can be chosen
    is_compiled          (problem, method) -> whether other threads can run beside its kernel
    stepper              (problem, method, step, steps, start, arrays) -> does more steps
    stepper_from_guess   as ``stepper``, for a step that begins with a guess
    guess_from_substeps  (substeps, problem, method, step, start, arrays) -> what the stages (d, s)
                         of the next step are, from smaller steps, or None
    guess_kind           what that is, as the kernels count it
    momenta              (problem, saved_v) -> conjugate momenta, (saved, ...)
    local_chart          (problem, method) -> what the coordinates of its curves mean
    energy_change        (problem, t, arrays) -> of the energy, see galvi.run.energy_check
    failure              (problem, method, step, code, solver, arrays) -> sentences: why the next
                         step failed, and the remedy
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
    energy_change: Callable[[Problem, float, RunArrays], float]
    failure: Callable[[Problem, Galerkin, float, int, str, RunArrays], str]
