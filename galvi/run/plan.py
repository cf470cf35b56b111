"""A run as a value, and the interface of the engines that do it: on vector spaces, on Lie groups
and in moving frames."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from galvi import input_checks
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


LARGEST_SLACK = 0.25  # steps by which a time may differ from a whole number of them


def number_of_steps(step: float, steps: int | None, duration: float | None) -> int:
    """``steps``, or the duration over the step; ValueError unless a whole number."""
    if (steps is None) == (duration is None):
        raise ValueError(
            "give either steps or duration; received " + ("neither." if steps is None else "both.")
        )
    if steps is not None:
        return input_checks.whole("steps", steps)
    length = input_checks.positive("duration", duration, "For backwards, make the step negative.")
    ratio = length / abs(step)
    if ratio > input_checks.LARGEST:
        input_checks.whole("duration over step", ratio)
    whole, sign = round(ratio), math.copysign(1.0, step)
    if whole < 1 or abs(ratio - whole) > min(1e-9 * whole, LARGEST_SLACK):
        raise ValueError(
            f"duration must be a whole number of steps; received {length!r} with step {step!r}, "
            f"{ratio:.6g} steps. Choose step={length / max(1, math.ceil(ratio)) * sign!r}"
            + (f" or {length / math.floor(ratio) * sign!r}." if ratio >= 1.0 else ".")
        )
    return whole


def steps_until(until: float, t0: float, step: float, done: int) -> int:
    """Steps from step number ``done`` to the time ``until``; ValueError unless a whole number."""
    ratio = (input_checks.real("until", until) - t0) / step
    whole = round(ratio) if abs(ratio) <= input_checks.LARGEST else 0
    slack = 1e-9 + 4.0 * math.ulp(max(abs(t0), abs(until))) / abs(step)  # of such times
    if whole <= done or abs(whole - ratio) > min(slack, LARGEST_SLACK):
        raise ValueError(
            f"until must be a whole number of steps after t = {t0 + done * step!r}, where the run "
            f"ends; received {until!r} with step {step!r}. Choose {t0!r} + n * {step!r}."
        )
    return whole - done
