"""Runs with events: found as the run goes on, ended or changed by them.

A run that events only watch is searched when it is done. One that they may end or change is done in
blocks: the steps before such an event are kept; it ends there, or goes on from the state that the
action returns, by one shortened step to the end of the step in which it happens, from which the
grid goes on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from typing import Any, cast

import numpy as np
from tqdm import tqdm

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import NOTHING, Checkpoint
from galvi.curves.clock_curves import ClockCurves, JoinedCurves, cut, merged
from galvi.curves.redone_curves import RedoneCurves
from galvi.events.block import CHUNK, piece_of, pieces
from galvi.events.event import changed, several_events
from galvi.events.search import MOST, START, Rows, Search
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.run.batches import APART
from galvi.run.clocked.run import at_step_limit
from galvi.run.engines import formulation_of, motion_in_clock
from galvi.run.integrate import prepared
from galvi.run.interruption import defer_interrupts
from galvi.run.point_masses.encounters import unresolved_passage
from galvi.run.request import RunRequest
from galvi.run.same_functions import SameFunctions
from galvi.run.states import saved_velocities
from galvi.run.status import SMALLER_STEP, notes_on_exceptions
from galvi.systems.lagrangian import momentum_at
from galvi.trajectory import DeferredEnding, Ending, Restarts, Trajectory

CHATTERS = 1000  # actions in one step
TOO_NEAR = 1e-6  # of a step, between two actions
FIRST = 8  # steps of the first block
AT_ONCE = 2**21  # numbers of a block and its curves, at most
TOO_MANY = f"more than {MOST} events"


def with_events(request: RunRequest, events: Any) -> Callable[..., Trajectory]:
    """A run with events, these checked, of ``progress`` and ``interrupted``."""
    search = Search(request.problem, request.method, several_events(events))
    acts = any(one.ends_or_acts for one in search.events)
    in_parts = acts or not (request.checkpoint.keeps_curves or request.method.clock)
    return partial(_acting if in_parts else _watched, request, search, acts)


def _watched(
    request: RunRequest, search: Search, acts: bool, *, progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:  # fmt: skip
    run = prepared(request)(progress=progress, interrupted=interrupted)
    beyond = None
    for piece in pieces(run) if run.counts["steps"] else ():
        search.on(piece)
        if search.count > MOST:
            beyond = float(piece.times[-1])
            break
    return _with_events(run, search, beyond)


def _with_events(run: Trajectory, search: Search, beyond: float | None = None) -> Trajectory:
    """The run with its events.

    beyond  the time after which none were sought, which makes it no success; None: all were
    """
    parts: dict[str, Any] = {field.name: getattr(run, field.name) for field in fields(run)}
    parts |= {"events": search.found(), "asked": search.events}
    if beyond is not None or search.status:

        def ending() -> Ending:
            outcome, checkpoint = run.ending.assess()
            if beyond is not None and outcome.success:
                outcome = Outcome(
                    End.STEP_FAILED, run.counts["steps"], beyond, TOO_MANY, outcome.notes,
                    outcome.steps, "None are sought later",
                )  # fmt: skip
            notes = filter(None, [*outcome.notes, search.status])
            return Ending(replace(outcome, notes=tuple(notes)), checkpoint)

        parts["ending"] = DeferredEnding(ending, run.ending.settings)
    return Trajectory(**parts)


def _row(number: float, *state: Any) -> tuple[Array, ...]:
    """A state t, q, p, v after a number of steps, as one of several."""
    return tuple(np.asarray(x)[None] for x in (number, *state))


def _acting(
    task: RunRequest, search: Search, acts: bool, *, progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:  # fmt: skip
    with np.errstate(all="ignore"), defer_interrupts() as pressed:
        acting = _Acting(task, search, acts, interrupted or pressed)
        with tqdm(total=task.steps, unit="step", disable=not progress) as bar:
            while acting.goes_on():
                before = acting.done
                acting.block()
                bar.update(acting.done - before)
        return acting.trajectory()


class _Acting:
    """A run that events may end or change, while it is done.

    own, start, before  the problem of its present part, the state from which it goes on, and the
                        run whose end that is
    rest                what is left of a step after an action, in the units of steps; None: nothing
    rows                kept states, the first one included
    parts               curves, and when each begins
    end                 how the run ended before its last step or at its time; None: it did not
    verdict             of its blocks, the first that is no success, or else the last in doubt or
                        with a note; None: none is
    """

    def __init__(
        self, task: RunRequest, search: Search, acts: bool, stopped: Callable[[], bool]
    ) -> None:
        self.task, self.search, self.stopped = task, search, stopped
        self.own, self.start, self.before = task.problem, task.checkpoint, task.continues
        self.most = input_checks.LARGEST if task.steps is None else task.steps
        self.clocked, self.passage = task.method.clock is not None, task.checkpoint.passage
        numbers = task.problem.q0.size * (1 + task.method.space.dimension)  # of a step
        self.at_once = min(CHUNK, max(AT_ONCE // numbers, FIRST))
        self.chunk = FIRST if acts else self.at_once
        self.done, self.within, self.whole = 0, 0, 0.0
        self.rest: float | None = None
        self.origin: Problem | None = None
        problem, first = task.problem, task.continues
        begin: Any = problem.t0, problem.q0, problem.p0, problem.v0
        if first is not None:
            begin = first.t[-1], first.q[-1], first.p[-1], first.v[-1]
        self.rows = [_row(0.0, *begin)]
        if not self.start.state.size:
            self.start = self._fresh(problem)
        self.base = self.start.first
        self.after, self.known = float(self.rows[0][1][0]), [self.start]
        self.parts: list[tuple[float, Any]] = []
        self.restarts: list[tuple[float, Array, Array]] = []
        self.counts: dict[str, int] = {}
        self.end: Outcome | None = None
        self.verdict: Outcome | None = None
        self.engine = self.engine_reason = ""
        self.names_passage = self.interrupted = False

    def goes_on(self) -> bool:
        """Whether there is more to do."""
        self.interrupted = self.interrupted or self.stopped()
        return self.done < self.most and self.end is None and not self.interrupted

    def block(self) -> None:
        """Some steps, up to an event that ends or changes the run."""
        n = min(self.chunk, self.most - self.done) if self.rest is None else 1
        part = self._steps(n)
        made = part.counts["steps"]
        reached = self.clocked and self.task.until is not None and part.t[-1] == self.task.until
        bound = self.clocked and made == n
        found = self.search.none()
        if made or reached:
            found = self.search.on(piece_of(part, self.done, self.after))
            if self.task.checkpoint.keeps_curves:
                self.parts.append((float(part.t[0]), part.curves))
        self.engine = self.engine or part.engine
        self.engine_reason = self.engine_reason or part.engine_reason
        for name, value in part.counts.items():
            self.counts[name] = self.counts.get(name, 0) + value
        stops = [k for k, i in enumerate(found.index) if self.search.events[i].ends_or_acts]
        if self.search.count > MOST:
            self._fail(self.done + made + 1, float(part.t[-1]), TOO_MANY)
        elif stops:
            self._stop(part, found, stops[0])
            return
        self._take(part, made, reached, bound)

    def _take(self, part: Trajectory, made: int, reached: bool, bound: bool) -> None:
        """A block without an event that ends or changes the run."""
        rows, outcome = len(part.t) - 1, self._judged(part)
        if self.rest is None:
            self._keep(part, rows)
            self.done, self.start = self.done + made, cast(Checkpoint, part.checkpoint)
            self.before = part
            if self.start.first - self.known[-1].first >= max(APART, self.done // 512):
                self.known.append(self.start)
        elif made:  # at the end of the step
            self._at_grid(part.t[-1], part.q[-1], part.p[-1], part.v[-1])
        elif reached:
            self.rows.append(_row(self.done + 0.5, *(x[-1] for x in (part.t, part.q, part.p,
                                                                       part.v))))  # fmt: skip
        if reached:
            self.end = self.end or Outcome()
        elif part.interrupted:
            self.interrupted = True
        elif (self.clocked and not bound) or not (made and np.all(np.isfinite(part.q[-1]))):
            self.end = self.end or outcome  # of a step that failed
        self.after = -math.copysign(math.inf, self.task.step)
        self.chunk = min(2 * self.chunk, self.at_once)

    def _stop(self, part: Trajectory, found: Rows, k: int) -> None:
        """An event that ends or changes the run, and others at its time."""
        t, whole = float(found.t[k]), int(found.step[k]) - self.done - 1
        same = START * abs(part.t[whole + 1] - part.t[whole])
        last = int(np.count_nonzero((found.t - t) * np.sign(self.task.step) <= same))
        self.search.rows[-1] = found.at(slice(last))
        self.search.count -= len(found.t) - last  # which are found anew
        if self.parts:
            self.parts[-1] = self.parts[-1][0], cut(part.curves, whole + 1)
        if self.rest is None and whole:
            steps = self._steps(whole)
            self._judged(steps)
            self._keep(steps, whole)
            self.done, self.start = self.done + whole, cast(Checkpoint, steps.checkpoint)
            self.before, self.within = steps, 0
        q, v = found.q[k], found.v[k]
        event = self.search.events[found.index[k]]
        if event.terminal:
            p = momentum_at(self.own.system, q, v, t)
            self.rows.append(_row(self.done + self._share(part, whole, t), t, q, p, v))
            name = self.search.asked[found.index[k]].name_of(int(found.part[k]))
            name = name or f"number {found.index[k]}"
            self.end = Outcome(End.STOPPED_BY_EVENT, time=t, steps=self.task.steps, event=name)
            return
        for index in found.index[k:last]:
            if (one := self.search.events[index]).action is not None:
                q, v = changed(one, self.own, q, v, t)
        if self.rest is None:
            self.whole = float(part.t[whole + 1] - part.t[whole])
        far = TOO_NEAR * abs(self.whole)
        near = bool(self.restarts) and abs(t - self.restarts[-1][0]) <= far
        self.restarts.append((t, q, v))
        self.within += 1
        if self.within > CHATTERS or near:
            self._fail(
                self.done + 1, t, f"the event {event.name} chatters, with {self.within} actions in "
                f"a step, or two too near to tell", "Let it end the run, by terminal=True",
            )  # fmt: skip
        length = self.task.step if self.rest is None else self.rest
        grid = float(part.t[whole + 1])
        self.rest = length * (1.0 - self._share(part, whole, t)) if self.clocked else grid - t
        self.own, self.after = self.own.moved(q, v, t), t
        self.before, self.chunk = None, max(2, min(self.chunk, 2 * whole))
        if abs(grid - t) <= 8.0 * math.ulp(max(abs(t), abs(grid))):
            self._at_grid(grid, q, momentum_at(self.own.system, q, v, t), v)

    def _at_grid(self, t: float, q: Array, p: Array, v: Array) -> None:
        """At the end of a step that an action changed: the grid goes on from here."""
        self.done, self.rest, self.within = self.done + 1, None, 0
        self.own = self.origin = self.own.moved(q, v, float(t))
        self.rows.append(_row(self.done, float(t), q, p, v))
        self.start, self.before = self._fresh(self.own, self.base + self.done), None

    def _steps(self, n: int) -> Trajectory:
        """n steps, or the rest of one, with curves and all states."""
        method, own = self.task.method, self.own
        start = self.start if self.rest is None else self._fresh(own)
        begin = replace(start, save_every=1, curves=True)
        step = self.task.step if self.rest is None else self.rest
        request = RunRequest(own, method, step, n, begin, self.task.until, self.before)
        return prepared(request)(interrupted=self.stopped)

    def _fresh(self, problem: Problem, first: int = 0) -> Checkpoint:
        """A state from which the problem begins; in a clock the number of its step is ``first``."""
        old, method = self.task.checkpoint, self.task.method
        if self.clocked:
            state = motion_in_clock(problem, method, old.solver, old.tolerance).at(
                problem.q0, problem.v0, problem.t0
            )
            return replace(state, first=first, solver=old.solver, tolerance=old.tolerance,
                           passage=self.passage)  # fmt: skip
        begin = formulation_of(problem, method).initial_state(problem, method)
        return Checkpoint(0, *begin, old.solver, old.tolerance)

    def _share(self, part: Trajectory, whole: int, t: float) -> float:
        """How much of its step is done at a time, in the clock's."""
        curves = part.curves
        if isinstance(curves, ClockCurves):
            since = np.array([t - curves.times[whole]])
            return float(curves._shares(np.array([whole]), since)[0])
        return (t - float(part.t[whole])) / (part.step or 1.0)

    def _keep(self, part: Trajectory, rows: int) -> None:
        """States of a block after its first."""
        here = np.arange(1, rows + 1)
        kept = here[((self.done + here) % self.task.checkpoint.save_every == 0) | (here == rows)]
        states = part.t[kept], part.q[kept], part.p[kept], saved_velocities(part, kept)
        self.rows.append((self.done + kept, *states))

    def _judged(self, part: Trajectory) -> Outcome:
        """The outcome of a block with the numbers of the run, which becomes the verdict if it says
        more."""
        seen = cast(Checkpoint, part.checkpoint).passage if self.clocked else NOTHING
        if seen.size and not (self.passage.size and self.passage[0] >= seen[0]):
            self.passage = seen
        outcome = replace(part.outcome, steps=self.task.steps)
        if outcome.step is not None:
            outcome = replace(outcome, step=outcome.step + self.done)
        of_the_block_alone = outcome.end in (End.INTERRUPTED, End.STEP_LIMIT)
        silent = outcome.end is End.COMPLETED and not (self.clocked and outcome.notes)
        decided = self.verdict is not None and not self.verdict.success
        if not (of_the_block_alone or silent or decided):
            self.verdict = outcome
            self.names_passage = bool(unresolved_passage(self.own, None, seen))
        return outcome

    def _fail(self, step: int, t: float, reason: str, remedy: str = "") -> None:
        self.end = Outcome(End.STEP_FAILED, step, t, reason, steps=self.task.steps, remedy=remedy)

    def _outcome(self, t: float) -> Outcome:
        """How the run ended, at time t."""
        task, verdict, end = self.task, self.verdict, self.end
        if end is None and self.interrupted:
            end = Outcome(End.INTERRUPTED, self.done + 1, t, steps=task.steps)
        elif end is None and task.until is not None:
            end = at_step_limit(self.done, t, self.most, task.until)
        end = end or Outcome(steps=task.steps)
        if not end.success:
            if verdict is None or verdict.end is not End.RUINED:
                return end
            note = f"It was ruined from step {verdict.step} on: {verdict.reason}."
            return replace(end, notes=(note,))
        if verdict is None and not self.clocked:
            formulation = formulation_of(task.problem, task.method)
            notes = notes_on_exceptions(formulation, {**self.counts, "steps": self.done})
            outcome = replace(end, notes=notes)
        elif verdict is None:
            outcome = end
        elif end.event and verdict.success:
            outcome = replace(
                end, reason=verdict.reason, remedy=verdict.remedy, notes=verdict.notes
            )
        else:
            outcome = replace(verdict, event=end.event, time=end.time)
        passage = unresolved_passage(task.problem, None, self.passage) if self.clocked else ""
        if not outcome.success or not passage or self.names_passage:
            return outcome
        return replace(
            outcome, end=End.STOPPED_BY_EVENT if outcome.event else End.DOUBTFUL,
            reason="; ".join(filter(None, [outcome.reason, passage])),
            remedy=outcome.remedy or SMALLER_STEP,
        )  # fmt: skip

    def trajectory(self) -> Trajectory:
        """What was done."""
        task, problem, h = self.task, self.task.problem, self.task.step
        every = task.checkpoint.save_every
        numbers, t, q, p, v = (np.concatenate(x) for x in zip(*self.rows, strict=True))
        rows = np.flatnonzero(np.append(numbers[:-1] % every == 0, True))
        numbers, t, q, p, v = (x[rows] for x in (numbers, t, q, p, v))
        last = float(t[np.isfinite(q.reshape(len(t), -1)).all(axis=1)][-1])
        curves: Any = None
        again: Any = None
        if task.checkpoint.keeps_curves and self.parts and self.restarts:
            times = np.array([*(begin for begin, _ in self.parts), last])
            times[0] = t[0]
            curves = JoinedCurves(read_only(times), tuple(part for _, part in self.parts))
        elif task.checkpoint.keeps_curves and self.parts:
            curves = merged([part for _, part in self.parts])
        elif not self.restarts:
            ends = self.done + (self.end is not None and self.end.success)
            again = RedoneCurves(
                problem,
                task.method,
                h,
                ends,
                ends,
                last,
                tuple(self.known),
                SameFunctions(problem, q, p, t, task.method.clock, False),
            )
        restarts = None
        if self.restarts:
            restarts = Restarts(*(np.array(x) for x in zip(*self.restarts, strict=True)))
        tau = None
        if self.clocked:
            begin = 0.0 if task.continues is None else float(cast(Array, task.continues.tau)[-1])
            tau = (self.base + numbers) * h
            tau[0] = begin
        massless = getattr(problem.system, "has_massless", False)
        old = task.checkpoint
        end = replace(self.start, save_every=old.save_every, curves=old.curves)
        run = Trajectory(
            problem, read_only(t), read_only(q), read_only(p),
            counts={**self.counts, "steps": self.done}, step=h, method=task.method, curves=curves,
            ending=Ending(self._outcome(last), end), interrupted=self.interrupted,
            velocities=read_only(v) if massless else None, again=again, engine=self.engine,
            engine_reason=self.engine_reason,
            tau=None if tau is None else read_only(tau), restarts=restarts, origin=self.origin,
        )  # fmt: skip
        return _with_events(run, self.search)
