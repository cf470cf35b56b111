"""One run: batches of steps that Ctrl-C can end, a second attempt at a step that fails, and the
resulting trajectory.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any, Protocol, cast

import numpy as np
from tqdm import tqdm

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import RedoneCurves
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.advance import HOLDS
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.energies import asks_force, asks_functions
from galvi.run.engine_choice import engine_for
from galvi.run.interruption import Interrupted, defer_interrupts, uninterrupted
from galvi.run.plan import COUNTED, NEVER, Engine, Run, RunArrays, RunCurves
from galvi.run.point_masses.encounters import MasslessError, massless_error
from galvi.run.run_samples import assess_run
from galvi.run.same_functions import of_run
from galvi.run.status import ending
from galvi.run.work_of_forces import assess_work, has_work
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

CALL_SECONDS = 0.1
GROWTH = 64.0  # largest ratio of the number of steps in a call to that in the call before


class Progress(Protocol):
    """The arrays that a run writes to, as far as this loop needs them."""

    @property
    def done(self) -> int:
        """Steps done so far."""


def step_in_batches(
    call: Callable[[int], int], recover: Callable[[int], int], work: Progress, steps: int,
    progress: bool | None, stopped: Callable[[], bool] = lambda: False, apart: int = 0,
    note: Callable[[], None] = lambda: None,
) -> int:  # fmt: skip
    """Do ``steps`` steps; returns the code of the last call, 0 if all are done or it was stopped.

    call     (n) does n steps and returns 0, or the code of the step that failed
    recover  (code) retries that step in another way and returns its code
    stopped  returns whether to stop
    note     is called after every ``apart`` steps but the last, if that is not 0
    """
    code, chunk = 0, 1
    # A bar makes a multiprocessing semaphore, which a killed process would leave behind.
    with tqdm(total=steps, unit="step") if progress else nullcontext() as bar:
        while code == 0 and work.done < steps and not stopped():
            before, clock = work.done, time.perf_counter()
            ahead = apart - before % apart if apart else steps
            code = call(min(chunk, ahead, steps - before))
            if code:
                code = recover(code)
            if apart and work.done % apart == 0 and before < work.done < steps:
                note()
            if bar is not None:
                bar.update(work.done - before)
            more = 0.5 * CALL_SECONDS / max(time.perf_counter() - clock, 1e-9)
            chunk = max(1, int((work.done - before) * min(max(more, 0.5), GROWTH)))
    return code


APART, MOST_KNOWN = 1024, 512  # steps between states from which curves can be found again


def run_steps(
    engine: Engine, run: Run, *, progress: bool | None = None, rescue: bool = True,
    watched: bool = True, interrupted: Callable[[], bool] | None = None,
) -> Trajectory:  # fmt: skip
    """The trajectory of a run.

    watched      whether its energy can be judged
    interrupted  returns whether to stop; None: Ctrl-C stops the run

    Raises `Interrupted` for Ctrl-C after the last step or one that failed; a run that was being
    judged is then judged when it is asked.

    With ``rescue``, a step that cannot be solved is retried once with a guess from smaller steps;
    if that fails too, the run ends. The energy of those smaller steps is not judged.
    """
    size, start = engine.curve_size(run.problem, run.method), run.start
    work = RunArrays.of(run, engine.velocity_row, size, watched=rescue and watched)

    def recover(code: int) -> int:
        guess = None
        if rescue:
            guess = engine.guess_from_substeps(
                lambda fine: run_steps(engine, fine, rescue=False), run, work
            )
        if guess is None:
            return code
        before, held = work.stages.copy(), work.solver_state[HOLDS]
        work.solver_state[HOLDS] = engine.guess_kind
        work.stages[:] = guess
        code = engine.stepper_from_guess(run, work)(1)
        if code:
            work.stages[:], work.solver_state[HOLDS] = before, held
        return code

    call = engine.stepper(run, work)
    known, apart = [start], 0
    massless = watched and _has_massless(run.problem)
    if rescue and (massless or not start.keeps_curves):
        apart = max(APART, -(-run.steps // MOST_KNOWN))
    with defer_interrupts() as pressed:
        code = step_in_batches(
            call, recover, work, run.steps, progress, interrupted or pressed, apart,
            lambda: known.append(_checkpoint(start, work)),
        )  # fmt: skip
        done = _trajectory(engine, run, work, code, known)
        if pressed() and not done.interrupted:
            raise Interrupted(done)
    system: Any = run.problem.system
    if watched and rescue and (asks_functions(system) or asks_force(system)):
        try:
            done._judge()  # now: what the functions refer to may change
        except KeyboardInterrupt:
            raise Interrupted(done) from None
    return done


def _trajectory(
    engine: Engine, run: Run, work: RunArrays, code: int, known: list[Checkpoint]
) -> Trajectory:
    """The trajectory of a run whose last kernel call returned ``code``, to be judged when asked.

    known  states from which its curves, and the error of bodies without mass, can be found
    """
    problem, method, step, steps, start = run[:5]
    done, shape = work.done, problem.q0.shape
    times: Array = problem.t0 + (start.first + work.saved_steps) * step
    curves = None
    if start.keeps_curves:
        bases, coefficients = read_only(work.bases), read_only(work.coefficients)
        curves = engine.curves(problem, method, step, run.begin, bases, coefficients)
    again = None
    if curves is None:
        q, v = work.saved_q, work.saved_v
        check = of_run(problem, q, v, times, None, bool(work.in_lanes))
        again = RedoneCurves(problem, method, step, steps, done, tuple(known), check)
    found = Trajectory(
        problem=problem,
        t=read_only(times),
        q=read_only(work.saved_q.reshape(-1, *shape)),
        p=read_only(engine.momenta(problem, work.saved_v)),
        velocities=_kept_velocities(problem, work),
        counts=_counts(engine, problem, work),
        step=step,
        method=method,
        curves=curves,
        again=again,
        interrupted=done < steps and code == SOLVED,
        engine="lanes" if engine.name == "general" and work.in_lanes else engine.name,
    )
    found._judge_later(lambda: _ending(engine, run, work, code, known), start)
    return found


def _ending(
    engine: Engine, run: Run, work: RunArrays, code: int, known: list[Checkpoint]
) -> Mapping[str, Any]:
    """The fields of a trajectory that tell how it ended."""
    start = run.start
    if has_work(run.problem.system):
        found = assess_work(engine, run, work, partial(_unwatched, engine))
    else:
        found = assess_run(engine, run, work)
    end = ending(
        engine, run, work, code, found,
        lambda: _massless_error(engine, run, work, known),
    )  # fmt: skip
    last = Checkpoint(
        start.first + work.done, read_only(work.state), read_only(work.stages), work.solver_state,
        start.solver, start.tolerance, start.save_every, start.curves, end.energies,
        read_only(work.passage[:FOUND]),
    )  # fmt: skip
    return {"success": end.success, "status": end.status, "failed_step": end.failed_step,
            "checkpoint": last}  # fmt: skip


def _unwatched(engine: Engine, run: Run) -> Trajectory:
    return uninterrupted(run_steps(engine, run, watched=False))


def _has_massless(problem: Problem) -> bool:
    return isinstance(problem.system, NBody) and problem.system.has_massless


def _massless_error(
    engine: Engine, run: Run, work: RunArrays, known: list[Checkpoint]
) -> MasslessError | None:
    """The estimate for bodies without mass; None without any, or where the run is not watched."""
    if work.watch == NEVER or not _has_massless(run.problem):
        return None
    _, stages, solver_state = engine.start(run.problem, run.method)

    def end(state: Checkpoint, n: int) -> Array:
        there = Checkpoint(
            -n * state.first, state.state, stages, solver_state, "auto", state.tolerance, n, False
        )
        back = run._replace(step=-run.step / n, steps=n, start=there)
        arrays = RunArrays.of(back, engine.velocity_row, (0, 0), watched=False)
        engine.stepper(back, arrays)(n)
        return np.stack([arrays.saved_q[-1], arrays.saved_v[-1]]).reshape(2, *run.problem.q0.shape)

    def ends(states: list[Checkpoint], n: int) -> Array:
        return np.stack([end(state, n) for state in states], axis=1)

    return massless_error(run.problem, ends, [*known, _checkpoint(run.start, work)])


def _checkpoint(start: Checkpoint, work: RunArrays) -> Checkpoint:
    """The current state of a run."""
    state = (work.state.copy(), work.stages.copy(), work.solver_state.copy())
    return Checkpoint(start.first + work.done, *state, start.solver, start.tolerance)


def curves_of_steps(
    problem: Problem, method: Galerkin, step: float, start: Checkpoint, skipped: int, count: int
) -> RunCurves:
    """The curves of ``count`` steps, ``skipped`` after a state of a run, for `RedoneCurves`."""
    engine = engine_for(problem, method)
    if skipped:
        there = replace(start, save_every=skipped, curves=False)
        before = uninterrupted(
            run_steps(engine, Run(problem, method, step, skipped, there), watched=False)
        )
        assert before.checkpoint is not None
        start = before.checkpoint
    begin = replace(start, save_every=1, curves=True)
    run = uninterrupted(run_steps(engine, Run(problem, method, step, count, begin), watched=False))
    return cast(RunCurves, run.curves)


def _kept_velocities(problem: Problem, work: RunArrays) -> Array | None:
    """The velocities at the saved states, where momenta do not determine them."""
    if _has_massless(problem):
        return read_only(work.saved_v.reshape(-1, *problem.v0.shape))
    return None


def _counts(engine: Engine, problem: Problem, work: RunArrays) -> dict[str, int]:
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
        result[engine.exceptions[0]] = left
    return result
