"""Runs with events, which may end or change them.

A run whose events neither end nor change it is searched after its last step, if its curves are kept
or it has a clock. Other runs are done and searched in blocks. At an event that ends or changes the
run, the steps before it are kept. The run ends there, or goes on from the state that the action
returns: by a shortened step to the end of the step in which the event happens, and on the grid from
there.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
from tqdm import tqdm

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves
from galvi.events.block import STEPS_AT_ONCE, piece_of, pieces
from galvi.events.event import as_events, state_after_action
from galvi.events.kept_states import KeptStates
from galvi.events.search import MAX_EVENTS, START_FRACTION, Rows, Search
from galvi.events.verdict import Verdict
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.run.batches import STEPS_BETWEEN_STATES
from galvi.run.clocked.run import outcome_at_step_limit
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.engines import motion_in_clock, stepper_for
from galvi.run.integrate import prepare_run
from galvi.run.interruption import defer_interrupts
from galvi.run.request import RunRequest
from galvi.run.stepper import Stepper
from galvi.systems.lagrangian import momentum_at
from galvi.trajectory import DeferredEnding, Ending, Trajectory

MAX_ACTIONS_IN_STEP = 1000  # largest number of actions in a step; with more an event chatters
LEAST_ACTION_GAP = 1e-6  # share of a step, the least time between two actions
FIRST_BLOCK_STEPS = 8  # steps of the first block where events may end or change the run
BLOCK_NUMBERS = 2**21  # about the largest number of entries in the states and curves of a block
TOO_MANY = f"more than {MAX_EVENTS} events"


def with_events(request: RunRequest, events: Any) -> Callable[..., Trajectory]:
    """A function of the keywords ``progress`` and ``interrupted`` that does a run with events;
    TypeError for values that are no events."""
    search = Search(request.problem, request.method, as_events(events))
    acts = any(event.ends_or_acts for event in search.events)
    if acts or not (request.checkpoint.keeps_curves or request.method.clock):
        return partial(
            _run_in_blocks, request, search, FIRST_BLOCK_STEPS if acts else STEPS_AT_ONCE
        )
    return partial(_search_after_run, request, search)


def _search_after_run(
    request: RunRequest,
    search: Search,
    *,
    progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:
    """A run that is searched after its last step."""
    run = prepare_run(request)(progress=progress, interrupted=interrupted)
    last_searched = search.search_pieces(pieces(run)) if run.counts["steps"] else None

    def ending() -> Ending:
        outcome, checkpoint = run.ending.assess()
        if last_searched is not None and outcome.success:
            outcome = Outcome(
                End.STEP_FAILED,
                run.counts["steps"],
                last_searched,
                TOO_MANY,
                outcome.notes,
                outcome.steps,
                "None are sought later",
            )
        return Ending(search.with_status(outcome), checkpoint)

    run_with_events = copy(run)
    vars(run_with_events).update(
        events=search.to_found(),
        asked=search.events,
        ending=DeferredEnding(ending, run.ending.settings),
    )
    return run_with_events


def _run_in_blocks(
    request: RunRequest,
    search: Search,
    chunk: int,
    *,
    progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:
    with np.errstate(all="ignore"), defer_interrupts() as pressed:
        run = BlockRun(request, search, chunk, interrupted or pressed)
        with tqdm(total=request.steps, unit="step", disable=not progress) as bar:
            while run.goes_on():
                before = run.steps_done
                run.block()
                bar.update(run.steps_done - before)
        return run.trajectory()


class BlockRun:
    """A run that is searched block by block, which events may end or change.

    Parameters
    ----------
    chunk
        steps of the next block

    Attributes
    ----------
    problem, start, before
        the problem of the current part, the state from which it goes on, and the run that ends at
        that state
    remainder
        the rest of the current step after an action, in the unit of steps; None where no action
        happened in it
    too_near
        the time up to which two actions in the step count as chattering
    after
        the time up to which events were searched
    end
        the outcome of a run that ended before its last step, or at its requested time; else None
    """

    def __init__(
        self, request: RunRequest, search: Search, chunk: int, stopped: Callable[[], bool]
    ) -> None:
        self.request, self.search, self.stopped = request, search, stopped
        self.stepper = stepper_for(request)
        self.verdict, self.recorded = Verdict(self.stepper), KeptStates(request)
        self.most_steps = input_checks.LARGEST_WHOLE if request.steps is None else request.steps
        self.problem, self.before = request.problem, request.continues
        self.start = (
            request.checkpoint if request.checkpoint.state.size else self._fresh(self.problem)
        )
        self.recorded.checkpoints.append(self.start)
        numbers = self.problem.q0.size * (1 + request.method.space.dimension)  # of a step
        self.at_once = min(STEPS_AT_ONCE, max(BLOCK_NUMBERS // numbers, FIRST_BLOCK_STEPS))
        self.chunk = min(chunk, self.at_once)
        self.steps_done = self.actions_in_step = 0
        self.remainder: float | None = None
        self.too_near = 0.0
        self.after = self.recorded.begin
        self.origin: Problem | None = None
        self.counts: Counter[str] = Counter()
        self.end: Outcome | None = None
        self.interrupted = False

    @property
    def clocked(self) -> bool:
        """Whether the run has a clock."""
        return isinstance(self.stepper, ClockStepper)

    def goes_on(self) -> bool:
        """Whether to do another block."""
        self.interrupted = self.interrupted or self.stopped()
        return self.steps_done < self.most_steps and self.end is None and not self.interrupted

    def block(self) -> None:
        """Do the steps of one block, up to an event that ends or changes the run."""
        part = self._steps(
            min(self.chunk, self.most_steps - self.steps_done) if self.remainder is None else 1
        )
        self.counts.update(part.counts)
        events = self.search.no_rows()
        if part.counts["steps"] or (self.clocked and part.curves is not None):
            events = self.search.search_piece(piece_of(part, self.steps_done, self.after))
            if self.request.checkpoint.keeps_curves:
                self.recorded.curves.append((float(part.t[0]), part.curves))
        stops = [k for k, i in enumerate(events.index) if self.search.events[i].ends_or_acts]
        if self.search.count > MAX_EVENTS:
            number = self.steps_done + part.counts["steps"] + 1
            self.end = self._failed(number, float(part.t[-1]), TOO_MANY)
        elif stops:
            self._stop(part, events, stops[0])
            return
        self._take(part)

    def _take(self, part: Trajectory) -> None:
        """Save a block without an event that ends or changes the run."""
        outcome = self.verdict.add(part, self.steps_done)
        at_requested_time = self.clocked and part.t[-1] == self.request.until
        if self.remainder is None:
            self._keep(part, part.counts["steps"])
        elif part.counts["steps"]:  # at the end of the step
            self._at_grid(part.t[-1], part.q[-1], part.p[-1], part.v[-1])
        elif at_requested_time:
            self.recorded.add(self.steps_done + 0.5, part.t[-1], part.q[-1], part.p[-1], part.v[-1])
        if at_requested_time:
            self.end = self.end or Outcome()
        elif part.interrupted:
            self.interrupted = True
        elif outcome.end is End.STEP_FAILED:
            self.end = self.end or outcome
        self.after = -math.copysign(math.inf, self.request.step)
        self.chunk = min(2 * self.chunk, self.at_once)

    def _stop(self, part: Trajectory, events: Rows, k: int) -> None:
        """End or change the run at event k of a part, and at the other events at its time."""
        t, full_steps = float(events.t[k]), int(events.step[k]) - self.steps_done - 1
        length = part.t[full_steps + 1] - part.t[full_steps]
        times_after_event = (events.t - t) * np.sign(self.request.step)
        last = int(np.count_nonzero(times_after_event <= START_FRACTION * abs(length)))
        self.search.keep_first(last)  # later events are searched again
        self.recorded.cut(full_steps + 1)
        if self.remainder is None and full_steps:
            part_before = self._steps(full_steps)
            self.verdict.add(part_before, self.steps_done)
            self._keep(part_before, full_steps)
        event = self.search.events[events.index[k]]
        fraction = _fraction_at(part, full_steps, t)
        if not event.terminal:
            self._act(part, full_steps, fraction, events.at(slice(k, last)))
            return
        q, v = events.q[k], events.v[k]
        self.recorded.add(
            self.steps_done + fraction, t, q, momentum_at(self.problem.system, q, v, t), v
        )
        name = self.search.bound_events[events.index[k]].name_of(int(events.part[k]))
        name = name or f"number {events.index[k]}"
        self.end = Outcome(End.STOPPED_BY_EVENT, time=t, steps=self.request.steps, event=name)

    def _act(self, part: Trajectory, full_steps: int, fraction: float, events: Rows) -> None:
        """Change the state by the actions of events at one time, one after another."""
        t, step_end = float(events.t[0]), float(part.t[full_steps + 1])
        q, v = events.q[0], events.v[0]
        for index in events.index:
            if self.search.events[index].action is not None:
                q, v = state_after_action(self.search.events[index], self.problem, q, v, t)
        length = self.remainder
        if length is None:
            length = self.request.step
            self.too_near = LEAST_ACTION_GAP * abs(step_end - float(part.t[full_steps]))
        restarts = self.recorded.restarts
        is_too_close = bool(restarts) and abs(t - restarts[-1][0]) <= self.too_near
        restarts.append((t, q, v))
        self.actions_in_step += 1
        if self.actions_in_step > MAX_ACTIONS_IN_STEP or is_too_close:
            name = self.search.events[events.index[0]].name
            event = f"the event {name}" if name else "an event"
            self.end = self._failed(
                self.steps_done + 1,
                t,
                f"{event} chatters, with {self.actions_in_step} actions "
                f"in a step, or two too near to tell",
                "Let it end the run, by terminal=True",
            )
        self.remainder = length * (1.0 - fraction) if self.clocked else step_end - t
        self.problem, self.after = self.problem.moved(q, v, t), t
        self.before, self.chunk = None, max(2, min(self.chunk, 2 * full_steps))
        if abs(step_end - t) <= 8.0 * math.ulp(max(abs(t), abs(step_end))):
            self._at_grid(step_end, q, momentum_at(self.problem.system, q, v, t), v)

    def _at_grid(self, t: float, q: Array, p: Array, v: Array) -> None:
        """Complete a step in which an action happened: the grid goes on from this state."""
        self.steps_done, self.remainder, self.actions_in_step = self.steps_done + 1, None, 0
        self.problem = self.origin = self.problem.moved(q, v, float(t))
        self.recorded.add(self.steps_done, float(t), q, p, v)
        first = self.request.checkpoint.first + self.steps_done if self.clocked else 0
        self.start, self.before = self._fresh(self.problem, first), None

    def _steps(self, n: int) -> Trajectory:
        """A run of n steps, or of the rest of the current one, with curves and all states."""
        method, until = self.request.method, self.request.until
        step, start = self.request.step, self.start
        if self.remainder is not None:
            step, start = self.remainder, self._fresh(self.problem)
        start_of_part = replace(start, save_every=1, curves=True)
        request = RunRequest(self.problem, method, step, n, start_of_part, until, self.before)
        return prepare_run(request)(interrupted=self.stopped)

    def _fresh(self, problem: Problem, first: int = 0) -> Checkpoint:
        """The start of a problem as a state after ``first`` steps."""
        method, settings = self.request.method, self.request.checkpoint
        if isinstance(self.stepper, Stepper):
            begin = self.stepper.formulation.initial_state(problem, method)
            return Checkpoint(0, *begin, settings.solver, settings.tolerance)
        motion = motion_in_clock(problem, method, settings.solver, settings.tolerance)
        state = motion.at(problem.q0, problem.v0, problem.t0)
        return replace(
            state,
            first=first,
            solver=settings.solver,
            tolerance=settings.tolerance,
            passage=self.verdict.passage,
        )

    def _keep(self, part: Trajectory, steps: int) -> None:
        """Save the states of a part of whole steps, and go on from its end."""
        self.recorded.add_part(part, self.steps_done)
        self.steps_done, self.before = self.steps_done + steps, part
        self.start = cast(Checkpoint, part.checkpoint)
        if self.start.first - self.recorded.checkpoints[-1].first >= max(
            STEPS_BETWEEN_STATES, self.steps_done // 512
        ):
            self.recorded.checkpoints.append(self.start)

    def _failed(self, step: int, t: float, reason: str, remedy: str = "") -> Outcome:
        return Outcome(End.STEP_FAILED, step, t, reason, steps=self.request.steps, remedy=remedy)

    def _ended(self, t: float) -> Outcome:
        """The outcome of the run, without its blocks' outcomes; it ended at time t."""
        if self.end is not None:
            return self.end
        if self.interrupted:
            return Outcome(End.INTERRUPTED, self.steps_done + 1, t, steps=self.request.steps)
        if self.request.until is not None:
            return outcome_at_step_limit(self.steps_done, t, self.most_steps, self.request.until)
        return Outcome(steps=self.request.steps)

    def trajectory(self) -> Trajectory:
        """The trajectory of the run."""
        request, problem, recorded = self.request, self.request.problem, self.recorded
        step_numbers, t, q, p, v = recorded.states()
        end_time = float(t[np.isfinite(q.reshape(len(t), -1)).all(axis=1)][-1])
        curves: Any = recorded.joined_curves(end_time)
        again = None
        if curves is None and not recorded.restarts:
            steps = self.steps_done + (self.end is not None and self.end.success)
            again = recorded.curves_again(steps, end_time, (q, p, t))
        tau = None
        if self.clocked:
            tau = (request.checkpoint.first + step_numbers) * request.step
            first = request.continues
            tau[0] = 0.0 if first is None else cast(Array, first.tau)[-1]
        counts = {**self.counts, "steps": self.steps_done}
        outcome = self.search.with_status(
            self.verdict.outcome_of_run(self._ended(end_time), counts)
        )
        settings = request.checkpoint
        end = replace(self.start, save_every=settings.save_every, curves=settings.curves)
        return Trajectory(
            problem, read_only(t), read_only(q), read_only(p), counts=counts, step=request.step,
            method=request.method, curves=curves, ending=Ending(outcome, end),
            interrupted=self.interrupted, again=again, engine=self.stepper.engine,
            velocities=read_only(v) if getattr(problem.system, "has_massless", False) else None,
            engine_reason=self.stepper.engine_reason, tau=None if tau is None else read_only(tau),
            restarts=recorded.all_restarts(), origin=self.origin, events=self.search.to_found(),
            asked=self.search.events,
        )  # fmt: skip


def _fraction_at(part: Trajectory, full_steps: int, t: float) -> float:
    """The fraction of a step in a clock at time t; 0.5 without a clock, where its value does not
    matter."""
    curves = part.curves
    if isinstance(curves, ClockCurves):
        since = np.array([t - curves.times[full_steps]])
        return float(curves._fractions(np.array([full_steps]), since)[0])
    return 0.5
