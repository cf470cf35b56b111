"""One run in a clock: its motion, its trajectory and how it ended."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import units_of_steps
from galvi.curves.clock_curves import ClockCurves, RedoneClockCurves
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.solve import SOLVED
from galvi.outcome import End, Outcome
from galvi.run.batches import step_in_batches
from galvi.run.clocked.in_lanes import motion_in_lanes
from galvi.run.clocked.plan import NO_COUNTS, Taken, costly_pair, joined
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.clocked.transformed import motion_in_transformed_time
from galvi.run.energies import States, asks_functions, start_energies
from galvi.run.energy_assessment import EnergyReport, Samples, assess_energy
from galvi.run.interruption import Interrupted, defer_interrupts
from galvi.run.point_masses.encounters import (
    STATES,
    MasslessError,
    massless_error,
    unresolved_passage,
)
from galvi.run.request import ROUND_OFF, RunRequest
from galvi.run.run_arrays import COUNTED
from galvi.run.same_functions import of_run
from galvi.run.status import completed, notes_on_energy
from galvi.run.stepper import Declined
from galvi.systems.lagrangian import velocity_at
from galvi.systems.nbody import NBody
from galvi.trajectory import DeferredEnding, Ending, Trajectory

TOO_LONG = "the step is too large for the clock"


def clock_energy(request: RunRequest) -> float | None:
    """The energy that a request's clock is told; None: that of the start.

    Raises ValueError for a clock that is not one of the problem's, or without an energy.
    """
    problem, start = request.problem, request.start
    request.method.clock.rate(problem)
    total = start_energies(problem).total
    if not math.isfinite(total):
        raise ValueError(
            f"a clock needs a finite energy at the start; received {total}. Start elsewhere."
        )
    return float(start.clock[2]) if start.clock.size and not start.state.size else None


def in_transformed_time(request: RunRequest, engine: str, reason: str) -> ClockStepper:
    """A stepper for any clock, whose steps are those of a problem in tau."""
    problem, method, energy = request.problem, request.method, clock_energy(request)
    total = start_energies(problem).total if energy is None else energy
    settings = request.start.solver, request.start.tolerance
    motion = motion_in_transformed_time(problem, method, total, *settings)
    return ClockStepper(request, motion, engine, f"{motion.reason}, since {reason}")


class Clock:
    """The engine of runs in a clock: by lanes for point masses, else in transformed time."""

    name = "clock"

    def offers(self, request: RunRequest) -> ClockStepper | Declined:
        """A stepper for a method with a clock."""
        start, method = request.start, request.method
        if method.clock is None:
            return Declined()
        energy = clock_energy(request)
        if start.solver == "newton" or start.tolerance != ROUND_OFF:
            settings = "the clock's lanes iterate to round-off, and other settings were asked for"
            return in_transformed_time(request, self.name, settings)
        motion = motion_in_lanes(request.problem, method, energy)
        if isinstance(motion, Declined):
            return in_transformed_time(request, self.name, motion.reason)
        return ClockStepper(request, motion, self.name, motion.reason)


CLOCK = Clock()


def run_in_clock(
    stepper: ClockStepper, *, progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:  # fmt: skip
    """The trajectory of a run in a clock.

    Raises `Interrupted` for Ctrl-C after the last step or one that failed.
    """
    loop, most = stepper, stepper.request.steps or input_checks.LARGEST
    loop.start_steps()
    with np.errstate(all="ignore"), defer_interrupts() as pressed:  # what is not finite is said
        stopped = interrupted or pressed
        code = step_in_batches(
            loop, lambda code: code, most, progress, lambda: loop.over or stopped()
        )
        run = _trajectory(loop, code)
        if pressed() and not run.interrupted:
            raise Interrupted(run)
    system: Any = stepper.problem.system
    if asks_functions(system) or getattr(system, "explicit_time", False):
        run.ending.assess()  # now: what the functions refer to may change
    return run


def _trajectory(loop: ClockStepper, code: int) -> Trajectory:
    """The trajectory of a loop whose last call returned ``code``, to be assessed when asked."""
    problem, start, h = loop.problem, loop.start, loop.step
    steps, first = loop.request.steps, loop.request.continues
    end, share = loop.to_time() if loop.reached else (None, 0.0)
    if end is not None:
        loop.note_passages(end)
    parts, numbers = list(loop.kept), [np.zeros(1), *(start.first + n for n in loop.numbers)]
    number = start.first + loop.done
    if end is not None:
        parts.append(end.rows([0]))
        numbers.append(np.array([number + share]))
    elif loop.done and not (numbers[-1].size and numbers[-1][-1] == number):
        parts.append(cast(Taken, loop.last))
        numbers.append(np.array([number]))
    tau = np.concatenate(numbers) * h
    begin = problem.q0, problem.p0, problem.v0, problem.t0
    if first is not None:
        tau[0] = cast(Array, first.tau)[-1]
        begin = first.q[-1], first.p[-1], first.v[-1], float(first.t[-1])
    massless = isinstance(problem.system, NBody) and problem.system.has_massless
    q, p, v = (np.reshape(x, (1, -1)) for x in begin[:3])
    clock = np.array([[begin[3], 0.0]])
    head = Taken(q, p, v if massless else None, clock, np.zeros((0, *problem.v0.shape)),
                 np.zeros((1, loop.method.stages)), NO_COUNTS)  # fmt: skip
    whole = joined([head, *(part._replace(coefficients=head.coefficients) for part in parts)])
    times = whole.t[:, 0]
    if loop.reached and loop.done + (end is not None):
        times[-1] = loop.time
    counts = {"steps": loop.done, **dict(zip(COUNTED, map(int, loop.counts), strict=True))}
    if isinstance(problem.system, NBody):
        counts["pair_evaluations"] = counts["force_evaluations"] * problem.system.pairs
    curves, last = loop.curves(end, share), float(times[-1])
    run = Trajectory(
        problem=problem,
        t=read_only(times),
        q=read_only(whole.q.reshape(-1, *problem.q0.shape)),
        p=read_only(whole.p.reshape(-1, *problem.v0.shape)),
        counts=counts,
        step=h,
        method=loop.method,
        curves=curves,
        ending=DeferredEnding(lambda: _ending(loop, run, end), start),
        again=None
        if curves is not None
        else RedoneClockCurves(
            problem,
            loop.method,
            h,
            tuple(loop.known),
            last,
            of_run(problem, whole.q, whole.p, times, loop.method.clock, False),
        ),
        interrupted=not (loop.over or loop.reached) and code == SOLVED and loop.done != steps,
        velocities=read_only(cast(Array, whole.v).reshape(-1, *problem.v0.shape))
        if massless
        else None,
        engine=loop.engine,
        engine_reason=loop.engine_reason,
        tau=read_only(tau),
    )
    return run


def _ending(loop: ClockStepper, run: Trajectory, end: Taken | None) -> Ending:
    """How the run of a loop ended."""
    start, notes = loop.start, []
    steps, step, t = loop.request.steps, loop.done + 1, float(run.t[-1])
    report, on_energy = EnergyReport(energies=start.energies), ()
    with np.errstate(all="ignore"):
        samples = _samples(loop, end)
    if samples is not None:
        report = assess_energy(loop.problem, samples, start.energies, lambda: loop.first_length)
        numbers, times = samples.steps, samples.states.t
        on_energy = notes_on_energy(
            report, start.first, lambda k: float(times[np.searchsorted(numbers, k)])
        )
    if loop.reason:
        reason = loop.reason.removesuffix(".")
        outcome = Outcome(End.STEP_FAILED, step, t, reason, on_energy, steps)
        if start.first + loop.done == 0:
            notes.append(f"Note that {units_of_steps(loop.problem, loop.method.clock)}.")
    elif run.interrupted:
        outcome = Outcome(End.INTERRUPTED, step, t, notes=on_energy, steps=steps)
    elif loop.time is not None and not loop.reached:
        outcome = at_step_limit(loop.done, t, cast(int, steps), loop.time)
        outcome = replace(outcome, notes=on_energy)
    else:
        outcome = completed(
            loop.problem, report, start.first,
            unresolved_passage(loop.problem, None, loop.passage),
            lambda: _massless_error(loop, run),
        )  # fmt: skip
    if isinstance(run.curves, ClockCurves) and (back := run.curves.steps_backwards()).size:
        begin = run.curves.times[back[0]]
        notes.append(f"The time does not grow along the step from t = {begin:.10g}: {TOO_LONG}.")
    notes.append(loop.motion.remark)
    if isinstance(loop.problem.system, NBody) and loop.seen and not loop.reason:
        q = np.concatenate([part.q for part in loop.seen])
        notes.append(costly_pair(loop.problem, q))
    outcome = replace(outcome, notes=(*outcome.notes, *filter(None, notes)))
    last = replace(loop.state, energies=report.energies, passage=read_only(loop.passage[:FOUND]),
                   save_every=start.save_every,
                   curves=start.curves, solver=start.solver, tolerance=start.tolerance)  # fmt: skip
    return Ending(outcome, last)


def at_step_limit(done: int, t: float, steps: int, time: float) -> Outcome:
    """The outcome of a run whose bound of ``steps`` steps was reached at t, before ``time``."""
    reason = f"the bound of {steps} steps was reached before t = {time:.10g}"
    remedy = "Give more steps, or a larger step"
    return Outcome(End.STEP_LIMIT, done + 1, t, reason, steps=steps, remedy=remedy)


def _massless_error(loop: ClockStepper, run: Trajectory) -> MasslessError | None:
    """What a step does to bodies without mass, at some of the kept states; None without any."""
    if not (isinstance(loop.problem.system, NBody) and loop.problem.system.has_massless):
        return None

    last, none = loop.state, np.zeros_like
    last = replace(last, stages=none(last.stages), solver_state=none(last.solver_state))

    def state_at(q: Array, v: Array, t: float) -> Checkpoint:
        state = np.zeros_like(last.state)
        state[0], state[2] = q.ravel(), v.ravel()
        return replace(last, state=state, clock=np.array([t, 0.0, *last.clock[2:]]))

    def ends(states: list[Checkpoint], n: int) -> Array:
        lengths = np.full(len(states), -loop.step / n)
        for _ in range(n):
            q, v, times, codes = cast(Any, loop.motion.each)(states, lengths)
            q[codes != SOLVED] = np.nan
            states = [state_at(*row) for row in zip(q, v, times, strict=True)]
        return np.stack([q, v]).reshape(2, -1, *loop.problem.q0.shape)

    rows = np.unique(np.linspace(0, len(run.t) - 1, STATES + 1).round().astype(int))
    states = [state_at(*row) for row in zip(run.q[rows], run.v[rows], run.t[rows], strict=True)]
    return massless_error(loop.problem, ends, states, STATES)


def _samples(stepper: ClockStepper, end: Taken | None) -> Samples | None:
    """Some steps, the last one among them, by whose energies a run is assessed; None: there are
    none."""
    problem = stepper.problem
    parts, places = list(stepper.seen), list(stepper.places)
    if end is not None:
        parts, places = [*parts, end.rows([0])], [*places, [stepper.done + 1]]
    elif stepper.done % stepper.stride:
        parts, places = [*parts, cast(Taken, stepper.last)], [*places, [stepper.done]]
    if not parts:
        return None
    taken, steps = joined(parts), stepper.start.first + np.concatenate(places)
    n, t, v = len(steps), taken.t[:, 0], taken.v
    q, p = taken.q.reshape(n, *problem.q0.shape), taken.p.reshape(n, *problem.v0.shape)
    if v is None:
        try:
            v = velocity_at(problem.system, q, p, t, problem.v0).reshape(n, -1)
        except Exception:  # `assess_energy` seeks them one by one, and says where that is
            v = np.repeat(problem.v0.reshape(1, -1), n, axis=0)
    return Samples(steps, States(q, p, v, t), taken.energy)
