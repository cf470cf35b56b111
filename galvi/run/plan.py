"""A run as a value, and the interface of the engines that do it: on vector spaces, on Lie groups
and in moving frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves, LocalChart
from galvi.curves.frame_curves import FrameCurves
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.trajectory import Trajectory


class Run(NamedTuple):
    """``steps`` steps of a problem by a method, checked, from a state with its settings.

    Of a longer run, which tells its steps, ``before`` were done, of ``total``.
    """

    problem: Problem
    method: Galerkin
    step: float
    steps: int
    start: Checkpoint
    before: int = 0
    total: int = 0

    @property
    def begin(self) -> float:
        """The time of its first state."""
        return self.problem.t0 + self.start.first * self.step


Call = Callable[[int], int]  # does n more steps; returns 0, or the code of a step that failed
Stepper = Callable[[Run, Any], Call]  # of a run and its arrays
RunCurves = Curves | FrameCurves
BY_NEWTON = (
    "Newton's method did {left} of {steps} steps, as accurately but more slowly, since fixed-point "
    "iteration did not converge there. A smaller step may take less time."
)
Start = tuple[Array, Array, npt.NDArray[np.int64]]


def fixed(*start: Any) -> Start:
    """The same arrays, not writeable."""
    return cast(Start, tuple(read_only(array) for array in start))


Substeps = Callable[[Run], Trajectory]  # with smaller steps, which are not retried when they fail


@dataclass(frozen=True)
class Engine:
    """The functions that differ between runs on vector spaces, on groups and in moving frames.

    There are three values, `NYSTROM`, `ON_GROUP` and `IN_FRAME`.

    start                (problem, method) -> state, stages and solver_state before the first step,
                         see `Checkpoint`; the same arrays for each run, which copies them
    velocity_row         row of the state that is saved with q: velocities or momenta
    solves_by_iteration  (problem, method) -> whether the solver fixed_point is available
    is_compiled          (problem, method) -> whether its kernel is compiled, so that other threads
                         can run at the same time
    stepper              (run, arrays) -> `Call`
    stepper_from_guess   as ``stepper``, for a step that starts from a given guess
    guess_from_substeps  (substeps, run, arrays) -> a guess (d, s) of the next step's stages from
                         smaller steps, or None
    guess_kind           the kernels' code for the kind of that guess
    momenta              (problem, saved_v) -> conjugate momenta, (saved, ...)
    curves               (problem, method, step, t0, bases, coefficients) -> the curves of a run
                         that starts at t0
    failure              (run, code, arrays) -> text: why the next step failed, and the remedy
    solvers              that it has
    exceptions           the name in a run's counts of steps that were done in another way, and what
                         its status says of them
    name                 "general", which lanes may do faster, or "frame"
    curve_size           (problem, method) -> numbers of a curve's base, and rows of its
                         coefficients
    """

    start: Callable[[Problem, Galerkin], Start]
    velocity_row: int
    solves_by_iteration: Callable[[Problem, Galerkin], bool]
    is_compiled: Callable[[Problem, Galerkin], bool]
    stepper: Stepper
    stepper_from_guess: Stepper
    guess_from_substeps: Callable[[Substeps, Run, Any], Array | None]
    guess_kind: int
    momenta: Callable[[Problem, Array], Array]
    curves: Callable[[Problem, Galerkin, float, float, Array, Array], RunCurves]
    failure: Callable[[Run, int, Any], str]
    solvers: tuple[str, ...] = ("auto", "fixed_point", "newton")
    exceptions: tuple[str, str] = ("newton_steps", BY_NEWTON)
    name: str = "general"
    curve_size: Callable[[Problem, Galerkin], tuple[int, int]] = lambda problem, method: (
        problem.q0.size, problem.v0.size,
    )  # fmt: skip


def curves_in(local_chart: Callable[[Problem, Galerkin], LocalChart]) -> Any:
    """The function ``curves`` of an engine from its chart of a problem and a method."""

    def curves(
        problem: Problem, method: Galerkin, step: float, t0: float, bases: Array, x: Array
    ) -> Curves:
        shaped = bases.reshape(-1, *problem.q0.shape)
        return Curves(method.space, t0, step, shaped, x, local_chart(problem, method))

    return curves
