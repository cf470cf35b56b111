"""The arrays that the steps of a run read and write, and how kernels take them."""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array, read_only
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.advance import DONE, UNWATCHED
from galvi.kernels.run_record import Plan, Progress, Recording
from galvi.problem import Problem
from galvi.run.request import RunRequest
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody

COUNT_NAMES = ("iterations", "force_evaluations", "hessian_evaluations", "linear_solves")
SECOND_KERNEL_STEPS, FORCES_IN_LANES = 5, 6  # indices in RunArrays.counts
# A longer run has FEWEST_WATCHED watched steps, or one in STEPS_PER_WATCH up to MANY_WATCHED, or
# one in STEPS_PER_LATER_WATCH up to WATCHED_TARGET; fewer than twice these numbers, since steps per
# watch are a power of 2.
FEWEST_WATCHED, MANY_WATCHED, WATCHED_TARGET = 16, 64, 1024
STEPS_PER_WATCH, STEPS_PER_LATER_WATCH = 64, 512
STEPS_ALL_WATCHED = 127  # steps of a run up to which each is watched


State = tuple[Array, Array, npt.NDArray[Any]]  # state, stages and solver_state, see `Checkpoint`


def fixed(*state: Any) -> State:
    """The arrays of a state, made read-only."""
    return cast(State, tuple(read_only(array) for array in state))


class RunArrays(NamedTuple):
    """The current state of a run and the arrays of its results.

    A configuration has r entries and a velocity d, which differ only on groups; there are s stages
    and m curve coefficients.

    Attributes
    ----------
    state, stages, solver_state
        see galvi.checkpoint
    step_angle : array, shape (1,)
        rotation angle of a failed step, radians; 0 without rotations
    counts
        (7,) the four of COUNT_NAMES, then evaluations of single pairs of bodies, steps that
        fixed-point iteration left to Newton's method or a moving frame to the inertial one, and
        force evaluations in lanes
    saved_steps : array, shape (saved,)
        numbers of completed steps of this run at the saved states
    saved_q : array, shape (saved, r)
        configurations, NaN until they are computed
    saved_moving : array, shape (saved, d)
        velocities, on groups momenta; NaN until computed
    bases, coefficients
        (steps, r), (steps, d, m) of the curves; no rows if these are not kept
    watch
        every 2^watch-th step since the problem's start is watched
    watched_states : array, shape (watched + 1, r + d)
        configurations and, as in saved_moving, velocities or momenta after the watched steps, with
        a spare row for the last step; for a Lagrangian (watched + 1, r + d + d s), with the stages
    passage
        see galvi.kernels.forces.passages; (0,) without point masses
    """

    state: Array
    stages: Array
    solver_state: npt.NDArray[np.int64]
    step_angle: Array
    counts: npt.NDArray[np.int64]
    saved_steps: Any
    saved_q: Array
    saved_moving: Array
    bases: Array
    coefficients: Array
    watch: int
    watched_states: Array
    passage: Array

    @classmethod
    def of(
        cls,
        request: RunRequest,
        state: State,
        row: int,
        curve_size: tuple[int, int],
        watched: bool = True,
    ) -> RunArrays:
        """Arrays for the equal steps of a run.

        Parameters
        ----------
        state
            from which it begins
        row
            row of the state that is saved in saved_moving
        curve_size
            size of a curve's base, and number of rows of its coefficients
        watched
            whether states are kept to assess the energy
        """
        problem, method, steps, start = (
            request.problem,
            request.method,
            cast(int, request.steps),
            request.checkpoint,
        )
        r, d, m = problem.q0.size, problem.v0.size, method.space.dimension - 1
        saved_steps = np.append(np.arange(0, steps, start.save_every), steps)
        saved_q, saved_moving = (np.full((len(saved_steps), width), np.nan) for width in (r, d))
        saved_q[0], saved_moving[0] = state[0][0, :r], state[0][row, :d]
        solver_state = state[2].copy()
        solver_state[DONE] = 0
        rows = steps if start.keeps_curves else 0
        watch = log2_steps_per_watch(steps) if watched else UNWATCHED
        watched_count = ((start.first + steps) >> watch) - (start.first >> watch) + watched
        stages = d * method.stages if isinstance(problem.system, Lagrangian) else 0
        passage = passage_record(problem, start.passage)
        return cls(
            state[0].copy(),
            state[1].copy(),
            solver_state,
            np.zeros(1),
            np.zeros(7, dtype=np.int64),
            saved_steps,
            saved_q,
            saved_moving,
            np.full((rows, curve_size[0]), np.nan),
            np.full((rows, curve_size[1], m), np.nan),
            watch,
            np.full((watched_count, r + d + stages), np.nan),
            passage,
        )

    @property
    def steps_done(self) -> int:
        """Number of completed steps."""
        return int(self.solver_state[DONE])

    @property
    def in_lanes(self) -> bool:
        """Whether vector instructions did steps, or began them."""
        return bool(self.counts[FORCES_IN_LANES])

    def record(self, request: RunRequest, q: Array, v: Array) -> None:
        """Count a step that ends at (q, v), as galvi.kernels.run_record does, without its curve."""
        start = request.checkpoint
        self.solver_state[DONE] += 1
        row, remainder = divmod(self.steps_done, start.save_every)
        if self.steps_done == request.steps:
            row, remainder = len(self.saved_q) - 1, 0
        if remainder == 0:
            self.saved_q[row], self.saved_moving[row] = q, v
        number = start.first + self.steps_done
        row = (number >> self.watch) - (start.first >> self.watch) - 1
        if number % (1 << self.watch) == 0 and row < len(self.watched_states):
            self.watched_states[row, : q.size + v.size] = np.concatenate([q, v])


def has_massless(problem: Problem) -> bool:
    """Whether some of the bodies are point masses without mass."""
    return isinstance(problem.system, NBody) and problem.system.has_massless


def passage_record(problem: Problem, passage: Array) -> Array:
    """The array in which kernels record passages of point masses, see
    galvi.kernels.forces.passages; (0,) for fewer than two.

    Parameters
    ----------
    passage
        the worst passage of earlier steps, or an empty array
    """
    system = problem.system
    if not isinstance(system, NBody) or system.masses.size < 2:
        return np.zeros(0)
    worst = passage if passage.size else np.zeros(FOUND)
    return np.array([*worst, problem.q0.shape[1], *(system.G * system.masses)])


def run_plan(
    request: RunRequest, work: RunArrays, tolerance: float
) -> tuple[tuple[Any, ...], tuple[Any, ...], tuple[Any, ...]]:
    """The tuples of `Plan`, `Progress` and `Recording` with which kernels do the steps of a run."""
    start = request.checkpoint
    plan = Plan(
        float(request.problem.t0),
        request.step,
        tolerance,
        start.first,
        cast(int, request.steps),
        start.save_every,
        work.watch,
    )
    progress = Progress(work.state, work.stages, work.solver_state, work.counts, work.passage)
    saved = Recording(
        work.saved_q, work.saved_moving, work.bases, work.coefficients, work.watched_states
    )
    return tuple(plan), tuple(progress), tuple(saved)


def log2_steps_per_watch(steps: int) -> int:
    """k, where every 2^k-th step of a run of ``steps`` steps is watched."""
    if steps <= STEPS_ALL_WATCHED:
        return 0
    target_count = min(
        max(
            steps // STEPS_PER_LATER_WATCH,
            min(steps // STEPS_PER_WATCH, MANY_WATCHED),
            FEWEST_WATCHED,
        ),
        WATCHED_TARGET,
    )
    return max(steps // target_count, 1).bit_length() - 1
