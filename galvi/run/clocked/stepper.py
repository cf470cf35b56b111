"""The steps of a run in a clock: those of the grid, in chunks, and a shortened one to a time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.curves.clock_curves import ClockCurves
from galvi.kernels.forces.passages import FOUND, compiled_note_states
from galvi.kernels.nystrom.solve import SOLVED
from galvi.problem import Problem
from galvi.run.batches import APART
from galvi.run.clocked.plan import Advanced, Motion, Taken, closest_pair, joined
from galvi.run.request import ALWAYS_FREE, RunRequest, free_memory
from galvi.systems.nbody import NBody

STANDS_STILL = 4.0  # ulp of the time, below which a step leaves it where it is
SEEN = 1024  # most states by whose energies a run is assessed
LARGEST = 2**22  # numbers of curves in a chunk of steps
NOT_POSITIVE = (
    "the clock is not positive at a stage of the step, or its time does not grow. Use a smaller "
    "step, or another clock"
)
NEWTON = 20  # iterations for the length of the last step
FULL = "what is kept fills half of the free memory. Keep fewer with save_every, and curves=False"


class ClockStepper:
    """The steps of one run in a clock, and what they gave.

    motion         how they are done
    engine         "clock", or "general" where that is alone
    kept, numbers  states at every save_every-th step, and their numbers in this run
    every          all steps, where curves are kept
    seen, places   states to assess by, after every ``stride``-th step, and the numbers of these
    last           the last one
    known          states from which its curves can be found
    passage        of point masses, as galvi.kernels.forces.passages has it; else empty
    """

    declined: tuple[str, ...] = ()  # by the engines that were asked before

    def __init__(
        self, request: RunRequest, motion: Motion, engine: str = "", reason: str = ""
    ) -> None:
        self.request, self.motion = request, motion
        self.engine, self._reason_of_engine = engine, reason
        self.problem, self.method, self.step = request[:3]

    @property
    def engine_reason(self) -> str:
        """Why this engine does the run, and why others do not."""
        return "; ".join(filter(None, [self._reason_of_engine, *self.declined]))

    @property
    def is_compiled(self) -> bool:
        """Whether other threads can run at the same time."""
        return isinstance(self.problem.system, NBody)

    def start_steps(self) -> None:
        """Make what the steps are kept in."""
        problem, start = self.problem, self.request.start
        state, fresh = start, self.motion.at(problem.q0, problem.v0, problem.t0)
        if not start.state.size:
            state = replace(
                fresh, solver=start.solver, tolerance=start.tolerance,
                save_every=start.save_every, curves=start.curves,
            )  # fmt: skip
        elif start.stages.shape != fresh.stages.shape:
            raise ValueError(
                "this run was done by another engine, whose states are not those of the one here "
                f"({self.engine_reason}). Resume it there, or make a problem of its end."
            )
        self.start = self.state = state
        self.time, self.done, self.counts, self.bytes = self.request.until, 0, np.zeros(4), 0
        self.over, self.reason = False, ""
        self.kept: list[Taken] = []
        self.numbers: list[Any] = []
        self.every: list[Taken] = []
        self.seen: list[Taken] = []
        self.places: list[Any] = []
        self.known, self.stride = [state], 1
        self.last: Taken | None = None
        self.passage = np.zeros(0)
        system = problem.system
        if isinstance(system, NBody) and system.masses.size > 1:
            worst = state.passage if state.passage.size else np.zeros(FOUND)
            self.passage = np.array([*worst, problem.q0.shape[1], *(system.G * system.masses)])

    def advance(self, n: int) -> int:
        """Does n more steps, or as many as there are."""
        keep = self.start.keeps_curves
        if keep:
            n = min(n, max(1, LARGEST // (self.problem.v0.size * self.method.space.dimension)))
        found = self.motion.advance(self.state, self.step, n, self.time, keep)
        t = found.taken.t[:, 0]
        dt = np.diff(t, prepend=self.state.clock[0])
        stuck = np.flatnonzero(np.abs(dt) < STANDS_STILL * np.spacing(np.abs(t)))
        with np.errstate(invalid="ignore"):
            lost = np.flatnonzero(
                ~(np.all(found.taken.rates > 0.0, axis=1) & (dt * self.step > 0.0))
            )
        if stuck.size:
            self.reason = _collision(self.problem, found.taken.q[stuck[0]], float(t[stuck[0]]))
            found = self.motion.advance(self.state, self.step, int(stuck[0]) + 1, None, keep)
        elif lost.size:
            n_good = int(lost[0])
            self.reason = NOT_POSITIVE
            found = (
                self.motion.advance(self.state, self.step, n_good, None, keep)
                if n_good
                else Advanced(found.taken.rows([]), self.state, SOLVED)
            )
        self.note_passages(found.taken)
        self._record(found.taken, keep)
        self.state, self.over = found.after, self.over or bool(stuck.size + lost.size)
        if not keep and self.done - (self.known[-1].first - self.start.first) >= APART:
            self.known.append(self.state)
        if found.code != SOLVED:
            self.reason = found.reason
        elif len(found.taken.t) < n:
            self.over = True
        return found.code

    def note_passages(self, taken: Taken) -> None:
        """Passages of two point masses that these steps do not resolve."""
        if not self.passage.size or not len(taken.t):
            return
        d, system = self.problem.v0.size, cast(NBody, self.problem.system)
        begin = self.state.state[:, :d]
        if taken.v is not None:
            v = np.concatenate([begin[2:3], taken.v])
        else:  # the state has momenta in transformed time
            p = np.concatenate([begin[1:2], taken.p])
            v = system.velocity(p.reshape(-1, *self.problem.v0.shape)).reshape(-1, d)
        compiled_note_states()(
            self.passage, np.concatenate([begin[:1], taken.q]), v,
            np.append(self.state.clock[:1], taken.t[:, 0]), self.method.space.dimension - 1,
        )  # fmt: skip

    def _record(self, taken: Taken, keep: bool) -> None:
        n = len(taken.t)
        self.counts += taken.counts
        if n == 0:
            return
        numbers = np.arange(self.done + 1, self.done + n + 1)
        every = self.start.save_every
        rows: Any = slice(None) if every == 1 else np.flatnonzero(numbers % every == 0)
        self.kept.append(taken.rows(rows))
        self.numbers.append(numbers[rows])
        self.last = taken.rows([-1])
        self._see(taken, numbers)
        if keep:
            self.every.append(taken)
        part = taken if keep else self.kept[-1]
        self.bytes += sum(getattr(array, "nbytes", 0) for array in part)
        if self.bytes > ALWAYS_FREE and self.bytes > 0.5 * (self.bytes + free_memory()):
            self.over, self.reason = True, FULL
        self.done += n

    @property
    def first_length(self) -> float:
        """The time that a step takes at the problem's start, about."""
        return float(self.motion.rate(self.problem.q0.ravel())) * self.step

    @property
    def q(self) -> Array:
        """The flat configuration after the last step."""
        return self.state.state[0, : self.problem.q0.size]

    def _see(self, taken: Taken, numbers: Any) -> None:
        """Keep the states after every 2^k-th step, at most ``SEEN``, whatever the portions."""
        rows = np.flatnonzero(numbers % self.stride == 0)
        self.seen.append(taken.rows(rows))
        self.places.append(numbers[rows])
        while sum(map(len, self.places)) > SEEN:
            self.stride *= 2
            places = np.concatenate(self.places)
            rows = np.flatnonzero(places % self.stride == 0)
            self.seen, self.places = [joined(self.seen).rows(rows)], [places[rows]]

    @property
    def reached(self) -> bool:
        """Whether the time asked for is reached, or would be passed by the next step."""
        if self.time is None or self.reason:
            return False
        t, low = self.state.clock[:2].tolist()
        return self.over or abs((self.time - t) - low) <= 2.0 * math.ulp(
            max(abs(self.time), abs(t))
        )

    def to_time(self) -> tuple[Taken | None, float]:
        """The shortened step from the last grid point to the time, by Newton's method for its share
        of a step; None where the grid point is there, or with a ``reason``."""
        t, low = self.state.clock[:2].tolist()
        time, rate, h = cast(float, self.time), self.motion.rate, self.step
        wanted, fine = (time - t) - low, 2.0 * math.ulp(max(abs(time), abs(t)))
        if abs(wanted) <= fine:
            return None, 0.0
        x, low_x, high_x = (min(1.0, wanted / (h * float(rate(self.q)))), 0.0, 2.0)
        best: tuple[float, Taken | None, float] = (math.inf, None, 0.0)
        for _ in range(NEWTON):
            found = self.motion.advance(self.state, x * h, 1, None, self.start.keeps_curves)
            self.counts += found.taken.counts
            if found.code != SOLVED:
                high_x, x = x, 0.5 * (low_x + x)
                continue
            after = found.taken.t[0]
            off = wanted - ((after[0] - t) + (after[1] - low))
            if abs(off) >= best[0]:
                break
            best = abs(off), found.taken, x
            if abs(off) <= 0.25 * fine:
                break
            low_x, high_x = (x, high_x) if off * h > 0.0 else (low_x, x)
            new = x + off / (h * float(rate(found.taken.q[0])))
            x = new if low_x < new < high_x else 0.5 * (low_x + high_x)
        if not best[0] <= 64.0 * fine:
            self.reason = "the step that ends there could not be solved. Use a smaller step"
            return None, 0.0
        return best[1], best[2]

    def curves(self, end: Taken | None, share: float) -> ClockCurves | None:
        """The curves of all steps, the shortened one included; None where they were not kept."""
        parts = [*self.every, *([end] if end is not None else [])]
        if not self.every and not (parts and self.start.keeps_curves):
            return None
        whole, first = joined(parts), self.start.state[0, : self.problem.q0.size]
        times = np.concatenate([self.start.clock[:1], whole.t[:, 0]])
        if self.reached:
            times[-1] = self.time
        bases = np.concatenate([first[None], whole.q[:-1]]).reshape(-1, *self.problem.q0.shape)
        last = self.step if end is None else share * self.step
        return ClockCurves(
            self.method, self.step, last, read_only(times), read_only(bases),
            read_only(whole.coefficients), read_only(whole.rates), self.motion.chart,
        )  # fmt: skip


def _collision(problem: Problem, q: Array, t: float) -> str:
    if np.spacing(abs(problem.t0)) > 16.0 * np.spacing(abs(t - problem.t0)):
        return (
            f"times near t0 = {problem.t0:g} are {np.spacing(abs(problem.t0)):.1e} apart, too far "
            f"for the next step. Shift t0 towards 0"
        )
    if isinstance(problem.system, NBody):
        one, other = closest_pair(problem, q)
        return (
            f"time stands still: bodies {one} and {other} collide. Stop before then, or merge them"
        )
    return "time stands still: the clock tends to 0, as at a collision. Stop before then"
