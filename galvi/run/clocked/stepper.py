"""The steps of a run in a clock: whole steps in chunks, and a shortened one to a requested time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.curves.clock_curves import ClockCurves
from galvi.kernels.forces.passages import compiled_note_states
from galvi.kernels.nystrom.solve import SOLVED
from galvi.problem import Problem
from galvi.run.clocked.motion import Advanced, ClockSteps, Motion, join_steps
from galvi.run.point_masses.pairs import closest_pair
from galvi.run.request import ALWAYS_FREE, RunRequest, free_memory
from galvi.run.run_arrays import COUNT_NAMES, has_massless, passage_record
from galvi.run.stepper import Engine, SavedStates
from galvi.systems.nbody import NBody

SMALLEST_TIME_CHANGE = 4.0  # in units in the last place of the time; below it time stands still
MAX_ENERGY_SAMPLES = 1024  # largest number of states by whose energies a run is assessed
CHUNK_NUMBERS = 2**22  # about the largest number of coefficients in a chunk of steps
NOT_POSITIVE = (
    "the clock is not positive at a stage of the step, or its time does not grow. Use a smaller "
    "step, or another clock"
)
LAST_STEP_ITERATIONS = 20  # largest number of iterations for the length of the last step
MEMORY_FULL = (
    "what is kept fills half of the free memory. Keep fewer with save_every, and curves=False"
)


class ClockStepper:
    """The steps of one run in a clock, and their records.

    Parameters
    ----------
    motion
        does the steps
    engine
        "clock", or "general" with GALVI_FAST=0

    Attributes
    ----------
    first_state
        the state before the first step; ``checkpoint`` is the current one
    recorded
        all steps, where curves are kept; else every save_every-th one, without its curve
    samples
        steps by whose ends the energy is assessed: every ``stride``-th one
    last
        the last whole step, without its curve
    failure_reason
        why a step failed; "" where none did
    end
        the shortened step to the requested time; None without one
    share
        length of that step over the length of a whole one
    passage
        the worst passage of point masses, see galvi.kernels.forces.passages; else empty
    """

    traced = False

    def __init__(
        self, request: RunRequest, motion: Motion, engine: str = "", reason: str = ""
    ) -> None:
        self.request, self.motion = request, motion
        self.engine, self.engine_reason = engine, reason
        self.problem, self.method, self.step = request[:3]

    @property
    def is_compiled(self) -> bool:
        """Whether several runs can proceed in threads."""
        return isinstance(self.problem.system, NBody)

    def begin(self, *, watched: bool = True) -> None:
        """Set the first state and empty records; ``watched`` states whether to keep samples by
        which the energy is assessed. ValueError for a state of another engine."""
        problem, start = self.problem, self.request.checkpoint
        state, fresh = start, self.motion.at(problem.q0, problem.v0, problem.t0)
        if not start.state.size:
            state = replace(
                fresh,
                solver=start.solver,
                tolerance=start.tolerance,
                save_every=start.save_every,
                curves=start.curves,
            )
        elif start.stages.shape != fresh.stages.shape:
            raise ValueError(
                "this run was done by another engine, whose states are not those of the one here "
                f"({self.engine_reason}). Resume it there, or make a problem of its end."
            )
        self.first_state = self.checkpoint = state
        self.time, self.steps_done, self.counts, self.bytes = self.request.until, 0, np.zeros(4), 0
        self.over, self.failure_reason = False, ""
        self.recorded: list[ClockSteps] = []
        self.samples: list[ClockSteps] = []
        self.stride, self.watched = 1, watched
        self.last: ClockSteps | None = None
        self.end: ClockSteps | None = None
        self.share = 1.0
        self.passage = passage_record(problem, state.passage)

    def retry(self, engines: Sequence[Engine], code: int) -> int:
        """Returns ``code``: a step in a clock is not retried."""
        return code

    @np.errstate(all="ignore")  # steps with numbers that are not finite fail
    def advance(self, n: int) -> int:
        """Does up to n steps, fewer where the requested time or a failure comes first or a chunk of
        curves is full; returns a code of galvi.kernels.nystrom.solve."""
        keep = self.first_state.keeps_curves
        if keep:
            n = min(
                n, max(1, CHUNK_NUMBERS // (self.problem.v0.size * self.method.space.dimension))
            )
        advanced = self.motion.advance(self.checkpoint, self.step, n, self.time, keep)
        t = advanced.steps.t[:, 0]
        dt = np.diff(t, prepend=self.checkpoint.clock[0])
        still_steps = np.flatnonzero(np.abs(dt) < SMALLEST_TIME_CHANGE * np.spacing(np.abs(t)))
        with np.errstate(invalid="ignore"):
            reversed_steps = np.flatnonzero(
                ~(np.all(advanced.steps.rates > 0.0, axis=1) & (dt * self.step > 0.0))
            )
        if still_steps.size:
            self.failure_reason = _collision(
                self.problem, advanced.steps.q[still_steps[0]], float(t[still_steps[0]])
            )
            advanced = self.motion.advance(
                self.checkpoint, self.step, int(still_steps[0]) + 1, None, keep
            )
        elif reversed_steps.size:
            n_good = int(reversed_steps[0])
            self.failure_reason = NOT_POSITIVE
            advanced = (
                self.motion.advance(self.checkpoint, self.step, n_good, None, keep)
                if n_good
                else Advanced(advanced.steps.rows([]), self.checkpoint, SOLVED)
            )
        self.note_passages(advanced.steps)
        self._record(advanced.steps, keep)
        self.checkpoint, self.over = (
            advanced.after,
            self.over or bool(still_steps.size + reversed_steps.size),
        )
        if advanced.code != SOLVED:
            self.failure_reason = advanced.reason
        elif len(advanced.steps.t) < n:
            self.over = True
        return advanced.code

    def note_passages(self, steps: ClockSteps) -> None:
        """Record in ``passage`` the worst passage of two point masses in these steps."""
        if not self.passage.size or not len(steps.t):
            return
        d, system = self.problem.v0.size, cast(NBody, self.problem.system)
        begin = self.checkpoint.state[:, :d]
        if steps.v is not None:
            v = np.concatenate([begin[2:3], steps.v])
        else:  # the state has momenta in transformed time
            p = np.concatenate([begin[1:2], steps.p])
            v = system.velocity(p.reshape(-1, *self.problem.v0.shape)).reshape(-1, d)
        compiled_note_states()(
            self.passage,
            np.concatenate([begin[:1], steps.q]),
            v,
            np.append(self.checkpoint.clock[:1], steps.t[:, 0]),
            self.method.space.dimension - 1,
        )

    def _record(self, steps: ClockSteps, keep: bool) -> None:
        n = len(steps.t)
        self.counts += steps.counts
        if n == 0:
            return
        self.recorded.append(steps if keep else steps.rows(self._is_saved(steps)))
        self.last = steps.rows([-1])
        if self.watched:
            self._sample(steps)
        self.bytes += sum(getattr(array, "nbytes", 0) for array in self.recorded[-1])
        if self.bytes > ALWAYS_FREE and self.bytes > 0.5 * (self.bytes + free_memory()):
            self.over, self.failure_reason = True, MEMORY_FULL
        self.steps_done += n

    @property
    def first_length(self) -> float:
        """The approximate length, in time, of a step at the problem's start."""
        return float(self.motion.rate(self.problem.q0.ravel())) * self.step

    def _is_saved(self, steps: ClockSteps) -> Any:
        """Whether the states after some steps are saved, (n,)."""
        return (steps.number - self.first_state.first) % self.first_state.save_every == 0

    def _sample(self, steps: ClockSteps) -> None:
        """Add every ``stride``-th step to the samples; where they become more than
        MAX_ENERGY_SAMPLES, double the stride and drop samples."""
        self.samples.append(self._every_so_many(steps))
        while sum(len(part.t) for part in self.samples) > MAX_ENERGY_SAMPLES:
            self.stride *= 2
            self.samples = [self._every_so_many(join_steps(self.samples))]

    def _every_so_many(self, steps: ClockSteps) -> ClockSteps:
        return steps.rows((steps.number - self.first_state.first) % self.stride == 0)

    @property
    def reached(self) -> bool:
        """Whether the requested time is reached, or would be passed by the next step."""
        if self.time is None or self.failure_reason:
            return False
        t, low = self.checkpoint.clock[:2].tolist()
        return self.over or abs((self.time - t) - low) <= 2.0 * math.ulp(
            max(abs(self.time), abs(t))
        )

    @np.errstate(all="ignore")
    def finish(self) -> None:
        """Does the shortened step to the requested time, where the next step would pass it."""
        if self.reached:
            self.end, self.share = self.to_time()
        if self.end is not None:
            self.note_passages(self.end)

    def to_time(self) -> tuple[ClockSteps | None, float]:
        """The shortened step from the last grid point to the requested time, and its length over
        that of a whole step, by Newton's method for that ratio. The step is None where the grid
        point is at that time, and where it cannot be solved, which sets ``failure_reason``."""
        t, low = self.checkpoint.clock[:2].tolist()
        time, rate, h = cast(float, self.time), self.motion.rate, self.step
        remaining, time_resolution = (time - t) - low, 2.0 * math.ulp(max(abs(time), abs(t)))
        if abs(remaining) <= time_resolution:
            return None, 1.0
        q = self.checkpoint.state[0, : self.problem.q0.size]
        x, low_x, high_x = (min(1.0, remaining / (h * float(rate(q)))), 0.0, 2.0)
        best: tuple[float, ClockSteps | None, float] = (math.inf, None, 0.0)
        for _ in range(LAST_STEP_ITERATIONS):
            advanced = self.motion.advance(
                self.checkpoint, x * h, 1, None, self.first_state.keeps_curves
            )
            self.counts += advanced.steps.counts
            if advanced.code != SOLVED:
                high_x, x = x, 0.5 * (low_x + x)
                continue
            after = advanced.steps.t[0]
            time_error = remaining - ((after[0] - t) + (after[1] - low))
            if abs(time_error) >= best[0]:
                break
            best = abs(time_error), advanced.steps, x
            if abs(time_error) <= 0.25 * time_resolution:
                break
            low_x, high_x = (x, high_x) if time_error * h > 0.0 else (low_x, x)
            new_x = x + time_error / (h * float(rate(advanced.steps.q[0])))
            x = new_x if low_x < new_x < high_x else 0.5 * (low_x + high_x)
        if not best[0] <= 64.0 * time_resolution:
            self.failure_reason = "the step that ends there could not be solved. Use a smaller step"
            return None, 1.0
        number = np.array([self.checkpoint.first + best[2]])
        return cast(ClockSteps, best[1])._replace(number=number), best[2]

    @property
    def curves(self) -> ClockCurves | None:
        """The curves of all steps, with the shortened one; None where they are not kept, and before
        the first step."""
        parts = self.recorded + ([self.end] if self.end is not None else [])
        if not parts or not self.first_state.keeps_curves:
            return None
        steps, first = join_steps(parts), self.first_state.state[0, : self.problem.q0.size]
        times = np.concatenate([self.first_state.clock[:1], steps.t[:, 0]])
        if self.reached:
            times[-1] = self.time
        bases = np.concatenate([first[None], steps.q[:-1]]).reshape(-1, *self.problem.q0.shape)
        return ClockCurves(
            self.method,
            self.step,
            self.share * self.step,
            read_only(times),
            read_only(bases),
            read_only(steps.coefficients),
            read_only(steps.rates),
            self.motion.chart,
        )

    def states(self) -> SavedStates:
        """The saved states: the first, those after every save_every-th step, and the last."""
        problem, continued_run = self.problem, self.request.continues
        first: Any = problem.t0, problem.q0, problem.p0, problem.v0, 0.0
        if continued_run is not None:
            tau = cast(Array, continued_run.tau)
            first = (
                continued_run.t[-1],
                continued_run.q[-1],
                continued_run.p[-1],
                continued_run.v[-1],
                tau[-1],
            )
        columns = [np.array(x)[None] for x in first]
        parts = [part.rows(self._is_saved(part)) for part in self.recorded]
        last = self.end if self.end is not None else self.last
        if last is not None:
            last_is_saved = self.end is None and self.steps_done % self.first_state.save_every == 0
            saved = join_steps(parts if last_is_saved else [*parts, last.rows([0])])
            v = saved.p if saved.v is None else saved.v
            steps = saved.t[:, 0], saved.q, saved.p, v, saved.number * self.step
            columns = [
                np.concatenate([x, rows.reshape(-1, *x.shape[1:])])
                for x, rows in zip(columns, steps, strict=True)
            ]
            if self.reached:
                columns[0][-1] = self.time
        t, q, p, velocities, tau = columns
        return SavedStates(t, q, p, velocities if has_massless(problem) else None, tau)

    def counted(self) -> dict[str, int]:
        """The counts of the run by name."""
        counts = {
            "steps": self.steps_done,
            **dict(zip(COUNT_NAMES, map(int, self.counts), strict=True)),
        }
        if isinstance(self.problem.system, NBody):
            counts["pair_evaluations"] = counts["force_evaluations"] * self.problem.system.pairs
        return counts


def _collision(problem: Problem, q: Array, t: float) -> str:
    if np.spacing(abs(problem.t0)) > 16.0 * np.spacing(abs(t - problem.t0)):
        return (
            f"times near t0 = {problem.t0:g} are {np.spacing(abs(problem.t0)):.1e} apart, too far "
            f"for the next step. Shift t0 towards 0"
        )
    if isinstance(problem.system, NBody):
        first, second = closest_pair(problem, q)
        return (
            f"time stands still: bodies {first} and {second} collide. Stop before then, "
            f"or merge them"
        )
    return "time stands still: the clock tends to 0, as at a collision. Stop before then"
