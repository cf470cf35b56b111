"""A run on a vector space: its kernel, the rescue of a step, and what is kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.vector_curves import Curves
from galvi.kernels.nystrom.advance import GUESS, HOLDS
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.batches import step_in_batches
from galvi.run.engines import fastest
from galvi.run.run_arrays import Workspace
from galvi.run.status import ending
from galvi.systems.nbody import NBody
from galvi.systems.system import VectorSystem
from galvi.trajectory import Trajectory

SUBSTEPS = (4, 16, 64, 256)


def march(
    problem: Problem,
    method: Galerkin,
    step: float,
    steps: int,
    start: Checkpoint,
    *,
    save_every: int = 1,
    curves: bool | None = None,
    progress: bool | None = None,
    rescue: bool = True,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:
    """Do ``steps`` steps from ``start``; arguments as for `galvi.integrate`, already checked.

    interrupted  says whether to stop; None means that Ctrl-C stops it

    When neither fixed point nor Newton solves a step, the step is tried once more from the path of
    a run with smaller steps (``rescue``); only then the run ends.
    """
    with_curves = save_every == 1 if curves is None else curves
    work = Workspace.of(start, method, steps, save_every, with_curves)
    call = fastest(problem, method, step, steps, save_every, start, work)

    def recover(code: int) -> int:
        if not rescue or start.solver == "fixed_point":
            return code
        t = problem.t0 + (start.first + work.done) * step
        guess = path_of_smaller_steps(problem, method, step, t, work)
        if guess is None:
            return code
        work.memo[HOLDS] = GUESS
        work.stages[:] = guess
        return call(1)

    code = step_in_batches(call, recover, work, steps, progress, interrupted)
    done, shape = work.done, problem.q0.shape
    states = work.saved.reshape(2, -1, *shape)
    t_first = problem.t0 + start.first * step
    return Trajectory(
        problem=problem,
        t=read_only(problem.t0 + (start.first + np.array(work.kept)) * step),
        q=read_only(states[0]),
        p=read_only(problem.system.momentum(states[1])),
        success=done == steps,
        interrupted=done < steps and code == SOLVED,
        status=ending(
            problem,
            code,
            start.solver,
            method.stages,
            step,
            done,
            steps,
            t_first + done * step,
            work.state,
        ),
        failed_step=None if done == steps else done + 1,
        counts=_counts(problem, done, work.counts),
        step=step,
        method=method,
        curves=Curves(
            method.space, t_first, step, read_only(work.bases), read_only(work.coefficients), shape
        )
        if with_curves
        else None,
        continuation=Checkpoint(
            start.first + done,
            read_only(work.state),
            read_only(work.stages),
            work.memo,
            start.solver,
            start.tolerance,
        ),
    )


def path_of_smaller_steps(
    problem: Problem, method: Galerkin, step: float, t: float, work: Workspace
) -> Array | None:
    """Accelerations (d, s) along a run from (t, state) with 4, 16, 64 or 256 steps in one.

    None when none of them can be solved by fixed-point iteration. Adds its cost to the counts.
    """
    shape = problem.q0.shape
    q, _, v, _ = work.state
    here = Problem(problem.system, q.reshape(shape), v.reshape(shape), t)
    for parts in SUBSTEPS:
        start = Checkpoint.at_start(here, method.stages, "fixed_point", 1e-8)
        run = march(here, method, step / parts, parts, start, rescue=False)
        work.counts[:2] += run.counts["iterations"], run.counts["force_evaluations"]
        if run.success:
            times = t + method.table.c * step
            path = run(times)
            work.counts[1] += len(times)
            system = cast(VectorSystem, problem.system)
            rows = [system.acceleration(q, s) for q, s in zip(path, times, strict=True)]
            return np.ascontiguousarray(np.stack(rows).reshape(len(times), -1).T)
    return None


def _counts(problem: Problem, done: int, counts: Any) -> dict[str, int]:
    iterations, forces, hessians, solves, pairs = (int(count) for count in counts)
    result = {
        "steps": done,
        "iterations": iterations,
        "force_evaluations": forces,
        "hessian_evaluations": hessians,
        "linear_solves": solves,
    }
    if isinstance(problem.system, NBody):
        bodies = problem.system.masses.size
        result["pair_evaluations"] = forces * (bodies * (bodies - 1) // 2) + pairs
    differenced = getattr(problem.system, "potential_calls_per_force", 0)
    if differenced:
        result["potential_evaluations"] = forces * differenced * problem.q0.size
    return result
