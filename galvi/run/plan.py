"""A run as a value, the arrays that it writes to, and the interface of the engines that do it: on
vector spaces, on Lie groups and in moving frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves, FrameCurves, LocalChart
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.advance import DONE
from galvi.kernels.run_record import Kept, Plan, Progress
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory


class Run(NamedTuple):
    """``steps`` steps of a problem by a method, checked, from a state with its settings."""

    problem: Problem
    method: Galerkin
    step: float
    steps: int
    start: Checkpoint

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
                         its outcome notes of them
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


COUNTED = ("iterations", "force_evaluations", "hessian_evaluations", "linear_solves")
LEFT_OVER, FORCES_IN_LANES = 5, 6  # indices in RunArrays.counts
FEWEST, MANY, MOST = 16, 64, 1024  # watched steps of a run: one in CLOSE up to MANY of them,
CLOSE, APART = 64, 512  # then one in APART
EACH = 127  # steps of a run up to which each is watched
ALWAYS_FREE = 2.0**28  # bytes; what needs no more is not compared with the memory that is free
NEVER = 62  # watches every 2^62-th step, which is none


def check_memory(runs: Sequence[Run]) -> None:
    """ValueError when runs that differ in their problems would keep more data than the memory that
    is free."""
    _, method, _, steps, start = runs[0][:5]
    d, m = sum(run.problem.q0.size for run in runs), method.space.dimension - 1
    halves = 2 if method.in_frame else 1  # places alone, or velocities too
    rows = 3 * (steps / start.save_every + 2)
    rows += steps * halves * (1 + m) if start.keeps_curves else 0
    needed = 8.0 * d * rows  # of rows: places, velocities, momenta; curves
    if needed > ALWAYS_FREE and needed > (memory := free_memory()):
        many = f"{len(runs)} runs of " if len(runs) > 1 else ""
        raise ValueError(
            f"{many}{steps} steps would keep {needed / 2**30:.3g} GiB in all, more than the "
            f"{memory / 2**30:.3g} GiB that are free on this machine. Keep fewer with save_every, "
            f"and curves=False."
        )


def free_memory() -> float:
    """Bytes of memory that processes can still have."""
    import psutil  # 0.05 s, which runs of little memory need not wait for

    return float(psutil.virtual_memory().available)


class RunArrays(NamedTuple):
    """The current state of a run and the results it keeps.

    A configuration has r entries and a velocity d, which differ only on groups; there are s stages
    and m curve coefficients.

    state, stages, solver_state  see galvi.checkpoint
    step_angle                   (1,) rotation angle of a failed step, radians; 0 without rotations
    counts                       (7,) as in COUNTED, then evaluations of single pairs of bodies,
                                 steps that fixed-point iteration left to Newton's method, or a
                                 moving frame to the inertial one, and force evaluations in lanes
    saved_steps                  (saved,) numbers of the saved steps
    saved_q                      (saved, r) configurations, NaN until they are computed
    saved_v                      (saved, d) velocities, on groups momenta; NaN until computed
    bases, coefficients          (steps, r), (steps, d, m) of the curves; no rows if not kept
    watch                        every 2^watch-th step since the problem's start is watched
    seen                         (watched + 1, r + d), as saved_q and saved_v, of the watched steps
                                 and room for the last; for a Lagrangian (watched + 1, r + d + d s),
                                 with the stages
    passage                      see galvi.kernels.forces.passages; (0,) without point masses
    """

    state: Array
    stages: Array
    solver_state: npt.NDArray[np.int64]
    step_angle: Array
    counts: npt.NDArray[np.int64]
    saved_steps: Any
    saved_q: Array
    saved_v: Array
    bases: Array
    coefficients: Array
    watch: int
    seen: Array
    passage: Array

    @classmethod
    def of(cls, run: Run, row: int, curve_size: tuple[int, int], watched: bool = True) -> RunArrays:
        """Arrays for the steps of a run; ``row`` of its first state is the first saved_v.

        curve_size  numbers of a curve's base, and rows of its coefficients
        watched     whether states are kept to judge the energy
        """
        problem, method, steps, start = run.problem, run.method, run.steps, run.start
        r, d, m = problem.q0.size, problem.v0.size, method.space.dimension - 1
        saved_steps = np.append(np.arange(0, steps, start.save_every), steps)
        saved_q, saved_v = (np.full((len(saved_steps), width), np.nan) for width in (r, d))
        saved_q[0], saved_v[0] = start.state[0, :r], start.state[row, :d]
        solver_state = start.solver_state.copy()
        solver_state[DONE] = 0
        rows = steps if start.keeps_curves else 0
        watch = watched_steps(steps) if watched else NEVER
        seen = ((start.first + steps) >> watch) - (start.first >> watch) + watched
        stages = d * method.stages if isinstance(problem.system, Lagrangian) else 0
        passage = np.zeros(0)
        if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
            known = start.passage if start.passage.size else np.zeros(FOUND)
            system = problem.system
            passage = np.array([*known, problem.q0.shape[1], *(system.G * system.masses)])
        return cls(
            start.state.copy(), start.stages.copy(), solver_state, np.zeros(1),
            np.zeros(7, dtype=np.int64), saved_steps, saved_q, saved_v,
            np.full((rows, curve_size[0]), np.nan), np.full((rows, curve_size[1], m), np.nan),
            watch, np.full((seen, r + d + stages), np.nan), passage,
        )  # fmt: skip

    @property
    def done(self) -> int:
        """Steps done so far."""
        return int(self.solver_state[DONE])

    @property
    def in_lanes(self) -> bool:
        """Whether vector instructions did steps, or began them."""
        return bool(self.counts[FORCES_IN_LANES])

    def record(self, run: Run, q: Array, v: Array) -> None:
        """Count a step that ends at (q, v), as galvi.kernels.run_record does, without its curve."""
        start = run.start
        self.solver_state[DONE] += 1
        row, rest = divmod(self.done, start.save_every)
        if self.done == run.steps:
            row, rest = len(self.saved_q) - 1, 0
        if rest == 0:
            self.saved_q[row], self.saved_v[row] = q, v
        number = start.first + self.done
        row = (number >> self.watch) - (start.first >> self.watch) - 1
        if number % (1 << self.watch) == 0 and row < len(self.seen):
            self.seen[row, : q.size + v.size] = np.concatenate([q, v])


def run_plan(
    run: Run, work: RunArrays, tolerance: float
) -> tuple[tuple[Any, ...], tuple[Any, ...], tuple[Any, ...]]:
    """The steps of a run, its current state and its kept results, as the kernels take them."""
    start = run.start
    plan = Plan(
        float(run.problem.t0), run.step, tolerance, start.first, run.steps, start.save_every,
        work.watch,
    )  # fmt: skip
    progress = Progress(work.state, work.stages, work.solver_state, work.counts, work.passage)
    kept = Kept(work.saved_q, work.saved_v, work.bases, work.coefficients, work.seen)
    return tuple(plan), tuple(progress), tuple(kept)


def watched_steps(steps: int) -> int:
    """k so that a run of ``steps`` steps is watched at every 2^k-th."""
    if steps <= EACH:
        return 0
    wanted = min(max(steps // APART, min(steps // CLOSE, MANY), FEWEST), MOST)
    return max(steps // wanted, 1).bit_length() - 1
