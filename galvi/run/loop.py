"""Does the steps of one run, in batches that Ctrl-C can end, and makes its trajectory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.redone_curves import RedoneCurves
from galvi.input_checks import LARGEST_WHOLE
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.advance import UNWATCHED
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.batches import STEPS_BETWEEN_STATES, step_in_batches
from galvi.run.clocked.run import ending_in_clock
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.energies import energy_calls_functions, work_calls_function
from galvi.run.engines import ENGINES, stepper_for
from galvi.run.interruption import Interrupted, defer_interrupts, uninterrupted
from galvi.run.point_masses.encounters import (
    STEPS_PER_STATE,
    MasslessError,
    examined_states,
    massless_error,
)
from galvi.run.request import RunRequest
from galvi.run.run_arrays import has_massless
from galvi.run.run_samples import assess_run
from galvi.run.same_functions import SameFunctions
from galvi.run.status import outcome_of
from galvi.run.stepper import RunCurves, Stepper, solve_steps
from galvi.run.work_of_forces import assess_work, has_work
from galvi.trajectory import DeferredEnding, Ending, Trajectory

MAX_CHECKPOINTS = 512  # of a run with a number of steps, from which curves are computed again


def run_steps(
    stepper: Stepper | ClockStepper,
    *,
    progress: bool | None = None,
    watched: bool = True,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:
    """The trajectory of a run.

    An equal step that cannot be solved is retried once, with a guess from smaller steps; if the
    second attempt fails too, the run ends.

    Parameters
    ----------
    stepper
        a `Stepper`, or in a clock a `ClockStepper`
    watched
        whether to keep states by which the energy can be assessed
    interrupted
        () -> whether to stop; None: Ctrl-C stops the run

    Raises
    ------
    Interrupted
        For Ctrl-C after the last step or one that failed. An interrupted assessment is repeated
        when the outcome is read.
    """
    stepper.begin(watched=watched)
    request = stepper.request
    problem, steps, note_every = request.problem, request.steps, 0
    if not request.checkpoint.keeps_curves or (watched and has_massless(problem)):
        steps_ahead = (
            0 if request.until is not None else steps or 0
        )  # in a clock there may be fewer
        note_every = max(STEPS_BETWEEN_STATES, -(-steps_ahead // MAX_CHECKPOINTS))
    checkpoints = [stepper.checkpoint]
    with defer_interrupts() as pressed:
        must_stop = interrupted or pressed
        code = step_in_batches(
            stepper,
            lambda code: stepper.retry(ENGINES, code),
            steps or LARGEST_WHOLE,
            progress,
            lambda: stepper.over or must_stop(),
            note_every,
            lambda: checkpoints.append(stepper.checkpoint),
        )
        stepper.finish()
        run = _trajectory(stepper, code, checkpoints)
        if pressed() and not run.interrupted:
            raise Interrupted(run)
    system: Any = problem.system
    has_time = getattr(system, "explicit_time", False)
    if watched and (energy_calls_functions(system) or work_calls_function(system) or has_time):
        try:
            run.ending.assess()  # before the numbers change to which the functions refer
        except KeyboardInterrupt:
            raise Interrupted(run) from None
    return run


def _trajectory(
    stepper: Stepper | ClockStepper, code: int, checkpoints: list[Checkpoint]
) -> Trajectory:
    """The trajectory of a run whose last kernel call returned ``code``, assessed when first read.

    Parameters
    ----------
    checkpoints
        states from which its curves, and the error of massless bodies, can be computed
    """
    problem, method, step, steps, start = stepper.request[:5]
    states, curves, redone_curves = stepper.states(), stepper.curves, None
    t, q, p, velocities, tau = (None if x is None else read_only(x) for x in states)
    if curves is None:
        check_functions = SameFunctions(
            problem, states.q, states.p, states.t, method.clock, stepper.traced
        )
        end_time = float(states.t[-1])
        redone_curves = RedoneCurves(
            problem,
            method,
            step,
            steps or 0,
            stepper.steps_done,
            end_time,
            tuple(checkpoints),
            check_functions,
        )
    counts = stepper.counted()

    def assess() -> Ending:
        if isinstance(stepper, ClockStepper):
            return ending_in_clock(stepper, run)
        return _assess_ending(stepper, code, counts, checkpoints)

    run = Trajectory(
        problem=problem,
        t=cast(Array, t),
        q=cast(Array, q),
        p=cast(Array, p),
        velocities=velocities,
        counts=counts,
        step=step,
        method=method,
        curves=curves,
        ending=DeferredEnding(assess, start),
        again=redone_curves,
        interrupted=code == SOLVED
        and not (stepper.over or stepper.reached)
        and stepper.steps_done != steps,
        engine=stepper.engine,
        engine_reason=stepper.engine_reason,
        tau=tau,
    )
    return run


def _assess_ending(
    stepper: Stepper, code: int, counts: dict[str, int], checkpoints: list[Checkpoint]
) -> Ending:
    """The ending of a run whose last kernel call returned ``code``."""
    formulation, request, work = stepper.formulation, stepper.request, stepper.work
    start = request.checkpoint
    if has_work(request.problem.system):
        report = assess_work(formulation, request, work, unwatched)
    else:
        report = assess_run(formulation, request, work)
    outcome = outcome_of(
        stepper, code, report, counts, lambda: _massless_error(stepper, checkpoints)
    )
    checkpoint = Checkpoint(
        start.first + work.steps_done,
        read_only(work.state),
        read_only(work.stages),
        work.solver_state,
        start.solver,
        start.tolerance,
        start.save_every,
        start.curves,
        report.energies,
        read_only(work.passage[:FOUND]),
    )
    return Ending(outcome, checkpoint)


def unwatched(request: RunRequest) -> Trajectory:
    """The run of a request, without an assessment of its energy; KeyboardInterrupt for Ctrl-C."""
    return uninterrupted(run_steps(stepper_for(request), watched=False))


def _massless_error(stepper: Stepper, checkpoints: list[Checkpoint]) -> MasslessError | None:
    """The error of massless bodies; None without such bodies, where the run is not watched, and
    where no step could be repeated."""
    request, work = stepper.request, stepper.work
    if work.watch == UNWATCHED or not has_massless(request.problem):
        return None
    _, stages, solver_state = stepper.formulation.initial_state(request.problem, request.method)

    states = [*checkpoints, stepper.checkpoint]
    examined = [
        states[row] for row in examined_states(len(states), work.steps_done, STEPS_PER_STATE)
    ]

    def state_after(state: Checkpoint, n: int) -> tuple[Array, Array]:
        begin = Checkpoint(
            -n * state.first, state.state, stages, solver_state, "auto", state.tolerance, n, False
        )
        request_back = request._replace(step=-request.step / n, steps=n, checkpoint=begin)
        arrays = solve_steps(ENGINES, request_back, retried=False)[0].work
        return arrays.saved_q[-1], arrays.saved_moving[-1]

    def states_after(n: int) -> Array:
        rows = np.stack([state_after(state, n) for state in examined], axis=1)
        return rows.reshape(2, -1, *request.problem.q0.shape)

    return massless_error(request.problem, states_after)


def curves_of_steps(
    problem: Problem, method: Galerkin, step: float, start: Checkpoint, skipped: int, count: int
) -> RunCurves:
    """The curves of ``count`` steps that follow the first ``skipped`` steps after a state."""
    if skipped:
        to_skip = replace(start, save_every=skipped, curves=False)
        before = unwatched(RunRequest(problem, method, step, skipped, to_skip))
        assert before.checkpoint is not None
        start = before.checkpoint
    start_of_curves = replace(start, save_every=1, curves=True)
    run = unwatched(RunRequest(problem, method, step, count, start_of_curves))
    return cast(RunCurves, run.curves)


def curves_from(
    problem: Problem, method: Galerkin, step: float, state: Checkpoint, time: float, end: float
) -> ClockCurves:
    """The curves of the steps in a clock from a state to ``time`` or the next end of a step, of a
    run that ended at ``end``: only its last step may have been shortened. ValueError where a step
    fails."""
    start = replace(state, save_every=1, curves=True)

    def run_to(steps: int | None, until: float) -> Trajectory:
        return unwatched(RunRequest(problem, method, step, steps, start, until))

    run = run_to(len(run_to(None, time).t) - 1, end)
    if run.curves is None:
        raise ValueError(f"the steps to t = {time!r} could not be done again. {run.status}")
    return cast(ClockCurves, run.curves)
