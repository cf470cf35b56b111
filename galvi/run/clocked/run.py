"""The engine of runs in a clock, and the ending of such a run."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import units_of_steps
from galvi.curves.clock_curves import ClockCurves
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.solve import SOLVED
from galvi.outcome import End, Outcome
from galvi.run.clocked.in_lanes import motion_in_lanes
from galvi.run.clocked.motion import join_steps
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.clocked.transformed import motion_in_transformed_time
from galvi.run.energies import States, start_energies
from galvi.run.energy_assessment import EnergyReport, Samples, assess_energy
from galvi.run.point_masses.encounters import (
    STEPS_PER_STATE_IN_A_CLOCK,
    MasslessError,
    examined_states,
    massless_error,
    unresolved_passage,
)
from galvi.run.point_masses.pairs import costly_pair
from galvi.run.request import ROUND_OFF, RunRequest
from galvi.run.run_arrays import has_massless
from galvi.run.status import notes_on_energy, outcome_of_completed
from galvi.run.stepper import Declined, Engine
from galvi.systems.lagrangian import velocity_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Ending, Trajectory

STEP_TOO_LARGE = "the step is too large for the clock"


def energy_at_start(request: RunRequest) -> float:
    """The energy at the problem's start; ValueError where the clock does not apply to the problem,
    and where the energy is not finite."""
    request.method.clock.rate(request.problem)
    total = start_energies(request.problem).total
    if not math.isfinite(total):
        raise ValueError(
            f"a clock needs a finite energy at the start; received {total}. Start elsewhere."
        )
    return total


def prescribed_energy(request: RunRequest) -> float | None:
    """The energy E that a request prescribes for its clock; None where E is that of the start."""
    start = request.checkpoint
    return float(start.clock[2]) if start.clock.size and not start.state.size else None


def in_transformed_time(
    request: RunRequest, engine: str, reason: str, energy: float
) -> ClockStepper:
    """A stepper for any clock, by equal steps of a problem in tau.

    Parameters
    ----------
    reason
        why the clock's lanes do not do the run, for `Stepper.engine_reason`
    energy
        the energy at the problem's start
    """
    problem, method, prescribed = request.problem, request.method, prescribed_energy(request)
    total = energy if prescribed is None else prescribed
    settings = request.checkpoint.solver, request.checkpoint.tolerance
    motion = motion_in_transformed_time(problem, method, total, *settings)
    return ClockStepper(request, motion, engine, f"{motion.reason}, since {reason}")


def stepper_in_clock(request: RunRequest) -> ClockStepper | Declined:
    """A stepper for a method with a clock: in lanes for point masses where these apply, else in
    transformed time."""
    start, method = request.checkpoint, request.method
    if method.clock is None:
        return Declined()
    energy = energy_at_start(request)
    if start.solver == "newton" or start.tolerance != ROUND_OFF:
        settings = "the clock's lanes iterate to round-off, and other settings were asked for"
        return in_transformed_time(request, CLOCK.name, settings, energy)
    motion = motion_in_lanes(request.problem, method, prescribed_energy(request))
    if isinstance(motion, Declined):
        return in_transformed_time(request, CLOCK.name, motion.reason, energy)
    return ClockStepper(request, motion, CLOCK.name, motion.reason)


CLOCK = Engine("clock", stepper_in_clock)


def ending_in_clock(stepper: ClockStepper, run: Trajectory) -> Ending:
    """The ending of the run of a stepper."""
    problem, start, notes = stepper.problem, stepper.first_state, []
    steps, step_number, t = stepper.request.steps, stepper.steps_done + 1, float(run.t[-1])
    report, energy_notes = EnergyReport(energies=start.energies), tuple[str, ...]()
    with np.errstate(all="ignore"):
        samples = _samples(stepper)
    if samples is not None:
        report = assess_energy(problem, samples, start.energies, lambda: stepper.first_length)
        numbers, times = samples.steps, samples.states.t
        energy_notes = notes_on_energy(
            report, start.first, lambda k: float(times[np.searchsorted(numbers, k)])
        )
    if stepper.failure_reason:
        reason = stepper.failure_reason.removesuffix(".")
        outcome = Outcome(End.STEP_FAILED, step_number, t, reason, energy_notes, steps)
        if start.first + stepper.steps_done == 0:
            notes.append(f"Note that {units_of_steps(stepper.problem, stepper.method.clock)}.")
    elif run.interrupted:
        outcome = Outcome(End.INTERRUPTED, step_number, t, notes=energy_notes, steps=steps)
    elif stepper.time is not None and not stepper.reached:
        outcome = outcome_at_step_limit(stepper.steps_done, t, cast(int, steps), stepper.time)
        outcome = replace(outcome, notes=energy_notes)
    else:
        outcome = outcome_of_completed(
            stepper.problem,
            report,
            start.first,
            unresolved_passage(stepper.problem, None, stepper.passage),
            lambda: _massless_error(stepper, run),
        )
    if (
        isinstance(run.curves, ClockCurves)
        and (backward_steps := run.curves.steps_backwards()).size
    ):
        begin = run.curves.times[backward_steps[0]]
        notes.append(
            f"The time does not grow along the step from t = {begin:.10g}: {STEP_TOO_LARGE}."
        )
    if isinstance(problem.system, NBody) and stepper.samples and not stepper.failure_reason:
        q = np.concatenate([part.q for part in stepper.samples])
        notes.append(costly_pair(problem, q))
    outcome = replace(outcome, notes=(*outcome.notes, *filter(None, notes)))
    checkpoint = replace(
        stepper.checkpoint,
        energies=report.energies,
        passage=read_only(stepper.passage[:FOUND]),
        save_every=start.save_every,
        curves=start.curves,
        solver=start.solver,
        tolerance=start.tolerance,
    )
    return Ending(outcome, checkpoint)


def outcome_at_step_limit(steps_done: int, t: float, steps: int, time: float) -> Outcome:
    """The outcome of a run that did all its ``steps`` and ended at t, before the requested time."""
    reason = f"the bound of {steps} steps was reached before t = {time:.10g}"
    remedy = "Give more steps, or a larger step"
    return Outcome(End.STEP_LIMIT, steps_done + 1, t, reason, steps=steps, remedy=remedy)


def _massless_error(stepper: ClockStepper, run: Trajectory) -> MasslessError | None:
    """The error of massless bodies at some of the saved states; None without such bodies, and where
    no step could be repeated."""
    if not has_massless(stepper.problem):
        return None

    last, shape = stepper.checkpoint, stepper.problem.q0.shape
    stages, solver_state = np.zeros_like(last.stages), np.zeros_like(last.solver_state)
    rows = examined_states(len(run.t), stepper.steps_done, STEPS_PER_STATE_IN_A_CLOCK, start=True)

    def state_at(q: Array, v: Array, t: float) -> Checkpoint:
        state, clock = np.zeros_like(last.state), last.clock.copy()
        state[0], state[2], clock[:2] = q.ravel(), v.ravel(), (t, 0.0)
        return Checkpoint(
            last.first, state, stages, solver_state, last.solver, last.tolerance, clock=clock
        )

    def states_after(n: int) -> Array:
        q, v, t = run.q[rows], run.v[rows], run.t[rows]
        lengths = np.full(len(q), -stepper.step / n)
        for _ in range(n):
            states = [state_at(*row) for row in zip(q, v, t, strict=True)]
            q, v, t, codes = cast(Any, stepper.motion.single_steps)(states, lengths)
            q[codes != SOLVED] = np.nan
        return np.stack([q, v]).reshape(2, -1, *shape)

    return massless_error(stepper.problem, states_after)


def _samples(stepper: ClockStepper) -> Samples | None:
    """The states by whose energies a run is assessed, with the last one; None before the first step
    and where the run is not watched."""
    problem, last = stepper.problem, stepper.end if stepper.end is not None else stepper.last
    if last is None or not stepper.watched:
        return None
    is_sampled = stepper.end is None and stepper.steps_done % stepper.stride == 0
    steps = join_steps(stepper.samples if is_sampled else [*stepper.samples, last.rows([0])])
    n, t, v = len(steps.t), steps.t[:, 0], steps.v
    q, p = steps.q.reshape(n, *problem.q0.shape), steps.p.reshape(n, *problem.v0.shape)
    if v is None:
        try:
            v = velocity_at(problem.system, q, p, t, problem.v0).reshape(n, -1)
        except Exception:  # `assess_energy` solves for them one by one, and reports where
            v = np.repeat(problem.v0.reshape(1, -1), n, axis=0)
    return Samples(np.ceil(steps.number).astype(np.int64), States(q, p, v, t), steps.energy)
