"""One run: batches of steps that Ctrl-C can end, a second attempt at a step that fails, and the
resulting trajectory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import RedoneCurves
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.batches import APART, step_in_batches
from galvi.run.clocked.run import run_in_clock
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.energies import asks_force, asks_functions
from galvi.run.engines import ENGINES, stepper_for
from galvi.run.interruption import Interrupted, defer_interrupts, uninterrupted
from galvi.run.point_masses.encounters import EACH, MasslessError, looked_at, massless_error
from galvi.run.request import RunRequest
from galvi.run.run_arrays import COUNTED, NEVER, RunArrays
from galvi.run.run_samples import assess_run
from galvi.run.same_functions import of_run
from galvi.run.status import outcome_of
from galvi.run.stepper import Formulation, RunCurves, Stepper, solve_steps
from galvi.run.work_of_forces import assess_work, has_work
from galvi.systems.nbody import NBody
from galvi.trajectory import DeferredEnding, Ending, Trajectory

MOST_KNOWN = 512  # states from which curves can be found again


def run_steps(
    stepper: Stepper, *, progress: bool | None = None, watched: bool = True,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:  # fmt: skip
    """The trajectory of a run of equal steps.

    A step that cannot be solved is retried once with a guess from smaller steps, whose energy is
    not assessed; if that fails too, the run ends.

    watched      whether its energy can be assessed
    interrupted  returns whether to stop; None: Ctrl-C stops the run

    Raises `Interrupted` for Ctrl-C after the last step or one that failed; a run that was being
    assessed is then assessed when it is asked.
    """
    stepper.start(watched=watched)
    work, request = stepper.work, stepper.request
    start, steps = request.start, cast(int, request.steps)

    def recover(code: int) -> int:
        return stepper.retry(ENGINES, code)

    known, apart = list[Checkpoint](), 0
    massless = watched and _has_massless(request.problem)
    if massless or not start.keeps_curves:
        apart = max(APART, -(-steps // MOST_KNOWN))
        known.append(_checkpoint(start, work))
    with defer_interrupts() as pressed:
        code = step_in_batches(
            stepper, recover, steps, progress, interrupted or pressed, apart,
            lambda: known.append(_checkpoint(start, work)),
        )  # fmt: skip
        done = _trajectory(stepper, code, known)
        if pressed() and not done.interrupted:
            raise Interrupted(done)
    system: Any = request.problem.system
    if watched and (asks_functions(system) or asks_force(system)):
        try:
            done.ending.assess()  # now: what the functions refer to may change
        except KeyboardInterrupt:
            raise Interrupted(done) from None
    return done


def _trajectory(stepper: Stepper, code: int, known: list[Checkpoint]) -> Trajectory:
    """The trajectory of a run whose last kernel call returned ``code``, to be assessed when asked.

    known  states from which its curves, and the error of bodies without mass, can be found
    """
    formulation, run, work = stepper.formulation, stepper.request, stepper.work
    problem, method, step, start, steps = *run[:3], run.start, cast(int, run.steps)
    done, shape = work.done, problem.q0.shape
    times: Array = problem.t0 + (start.first + work.saved_steps) * step
    curves = None
    if start.keeps_curves:
        bases, coefficients = read_only(work.bases), read_only(work.coefficients)
        curves = formulation.curves(problem, method, step, run.begin, bases, coefficients)
    again = None
    if curves is None:
        q, v = work.saved_q, work.saved_v
        check = of_run(problem, q, v, times, None, bool(work.in_lanes))
        again = RedoneCurves(problem, method, step, steps, done, tuple(known), check)
    counts = _counts(formulation, problem, work)
    return Trajectory(
        problem=problem,
        t=read_only(times),
        q=read_only(work.saved_q.reshape(-1, *shape)),
        p=read_only(formulation.momenta(problem, work.saved_v)),
        velocities=_kept_velocities(problem, work),
        counts=counts,
        step=step,
        method=method,
        curves=curves,
        ending=DeferredEnding(lambda: _ending(stepper, code, counts, known), start),
        again=again,
        interrupted=done < steps and code == SOLVED,
        engine=stepper.engine,
        engine_reason=stepper.engine_reason,
    )


def _ending(stepper: Stepper, code: int, counts: dict[str, int], known: list[Checkpoint]) -> Ending:
    """How a run ended whose last kernel call returned ``code``."""
    formulation, run, work = stepper.formulation, stepper.request, stepper.work
    start = run.start
    if has_work(run.problem.system):
        report = assess_work(formulation, run, work, unwatched)
    else:
        report = assess_run(formulation, run, work)
    outcome = outcome_of(stepper, code, report, counts, lambda: _massless_error(stepper, known))
    last = Checkpoint(
        start.first + work.done, read_only(work.state), read_only(work.stages), work.solver_state,
        start.solver, start.tolerance, start.save_every, start.curves, report.energies,
        read_only(work.passage[:FOUND]),
    )  # fmt: skip
    return Ending(outcome, last)


def unwatched(request: RunRequest) -> Trajectory:
    """A run of equal steps whose energy is not assessed; KeyboardInterrupt for Ctrl-C."""
    stepper = cast(Stepper, stepper_for(request))
    return uninterrupted(run_steps(stepper, watched=False))


def _has_massless(problem: Problem) -> bool:
    return isinstance(problem.system, NBody) and problem.system.has_massless


def _massless_error(stepper: Stepper, known: list[Checkpoint]) -> MasslessError | None:
    """The estimate for bodies without mass; None without any, or where the run is not watched."""
    run, work = stepper.request, stepper.work
    if work.watch == NEVER or not _has_massless(run.problem):
        return None
    _, stages, solver_state = stepper.formulation.start(run.problem, run.method)

    states = [*known, _checkpoint(run.start, work)]
    chosen = [states[row] for row in looked_at(len(states), work.done, EACH)]

    def end(state: Checkpoint, n: int) -> tuple[Array, Array]:
        there = Checkpoint(
            -n * state.first, state.state, stages, solver_state, "auto", state.tolerance, n, False
        )
        back = run._replace(step=-run.step / n, steps=n, start=there)
        arrays = solve_steps(ENGINES, back, retried=False)[0].work
        return arrays.saved_q[-1], arrays.saved_v[-1]

    def ends(n: int) -> Array:
        rows = np.stack([end(state, n) for state in chosen], axis=1)
        return rows.reshape(2, -1, *run.problem.q0.shape)

    return massless_error(run.problem, ends)


def _checkpoint(start: Checkpoint, work: RunArrays) -> Checkpoint:
    """The current state of a run."""
    state = (work.state.copy(), work.stages.copy(), work.solver_state.copy())
    return Checkpoint(start.first + work.done, *state, start.solver, start.tolerance)


def curves_of_steps(
    problem: Problem, method: Galerkin, step: float, start: Checkpoint, skipped: int, count: int
) -> RunCurves:
    """The curves of ``count`` steps, ``skipped`` after a state of a run, for `RedoneCurves`."""
    if skipped:
        there = replace(start, save_every=skipped, curves=False)
        before = unwatched(RunRequest(problem, method, step, skipped, there))
        assert before.checkpoint is not None
        start = before.checkpoint
    begin = replace(start, save_every=1, curves=True)
    run = unwatched(RunRequest(problem, method, step, count, begin))
    return cast(RunCurves, run.curves)


def curves_from(
    problem: Problem, method: Galerkin, step: float, state: Checkpoint, time: float, end: float
) -> ClockCurves:
    """The curves in a clock from a state to the first end of a step past a time, of a run that
    ended at ``end``: only its last step may have been shortened."""
    there = replace(state, save_every=1, curves=True)

    def again(steps: int | None, until: float) -> Trajectory:
        request = RunRequest(problem, method, step, steps, there, until)
        return run_in_clock(cast(ClockStepper, stepper_for(request)))

    run = again(len(again(None, time).t) - 1, end)
    if run.curves is None:
        raise ValueError(f"the steps to t = {time!r} could not be done again. {run.status}")
    return cast(ClockCurves, run.curves)


def _kept_velocities(problem: Problem, work: RunArrays) -> Array | None:
    """The velocities at the saved states, where momenta do not determine them."""
    if _has_massless(problem):
        return read_only(work.saved_v.reshape(-1, *problem.v0.shape))
    return None


def _counts(formulation: Formulation, problem: Problem, work: RunArrays) -> dict[str, int]:
    *counted, pairs, left, in_lanes = work.counts.tolist()
    result = {"steps": work.done, **dict(zip(COUNTED, counted, strict=True))}
    forces = result["force_evaluations"]
    if isinstance(problem.system, NBody):
        result["pair_evaluations"] = forces * problem.system.pairs + pairs
    differenced = getattr(problem.system, "potential_calls_per_force", 0)
    if differenced and forces > in_lanes:
        called = forces - in_lanes
        result["potential_evaluations"] = called * differenced * problem.v0.size
    if left:
        result[formulation.in_other_way[0]] = left
    return result
