"""The loop around the kernel: a bounded number of steps a call, rescue, progress, what is kept."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from tqdm import tqdm

from galvi.arrays import Array, read_only
from galvi.continuation import Continuation
from galvi.curves import Curves
from galvi.interruption import noted_interrupts
from galvi.kernels.advance import DONE, GUESS, HOLDS, advance, compiled_advance
from galvi.kernels.interpreted import interpreted
from galvi.kernels.solve import AUTO, FIXED_POINT, NEWTON, NOT_FINITE, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.field import Field
from galvi.trajectory import COMPLETED, Trajectory

SOLVERS = {"auto": AUTO, "fixed_point": FIXED_POINT, "newton": NEWTON}
CALL_SECONDS = 0.1
SUBSTEPS = (4, 16, 64, 256)


def march(
    problem: Problem,
    method: Galerkin,
    step: float,
    steps: int,
    start: Continuation,
    *,
    save_every: int = 1,
    curves: bool | None = None,
    progress: bool | None = None,
    rescue: bool = True,
) -> Trajectory:
    """Do ``steps`` steps from ``start``; arguments as for `galvi.integrate`, already checked.

    When neither fixed point nor Newton solves a step, the step is tried once more from the path of
    a run with smaller steps (``rescue``); only then the run ends.
    """
    field = problem.system.field(problem.q0.shape[-1])
    tableau = kernel_tableau(method)
    d, m = problem.q0.size, method.space.dimension - 1
    kept = [*range(0, steps, save_every), steps]
    saved = np.full((2, len(kept), d), np.nan)
    state, stages, memo = start.state.copy(), start.stages.copy(), start.memo.copy()
    saved[0, 0], saved[1, 0] = state[0], state[2]
    with_curves = save_every == 1 if curves is None else curves
    bases = np.full((steps if with_curves else 0, d), np.nan)
    coefficients = np.full((len(bases), d, m), np.nan)
    counts = np.zeros(4, dtype=np.int64)
    memo[DONE] = 0
    kernel = compiled_advance() if field.compiled else interpreted(advance)

    def call(todo: int) -> int:
        return int(kernel(
            field.kind, field.law, field.law_jacobian, field.gradient, field.timed_gradient,
            field.hessian, field.timed_hessian, field.has_hessian, field.constants,
            field.inverse_mass, field.width, tableau, problem.t0, step, SOLVERS[start.solver],
            start.tolerance, start.first, todo, steps, save_every, state, stages, memo, counts,
            saved[0], saved[1], bases, coefficients,
        ))  # fmt: skip

    code, chunk = SOLVED, 1
    with noted_interrupts() as stopped, tqdm(total=steps, disable=not progress, unit="step") as bar:
        while code == SOLVED and memo[DONE] < steps and not stopped():
            before, clock = int(memo[DONE]), time.perf_counter()
            code = call(min(chunk, steps - before))
            if code != SOLVED and rescue and start.solver != "fixed_point":
                t = problem.t0 + (start.first + int(memo[DONE])) * step
                guess = path_of_smaller_steps(problem, method, step, t, state, counts)
                if guess is not None:
                    memo[HOLDS] = GUESS
                    stages[:] = guess
                    code = call(1)
            bar.update(int(memo[DONE]) - before)
            quick = time.perf_counter() - clock < 0.5 * CALL_SECONDS
            chunk = max(1, chunk * 2 if quick else chunk // 2)
    done = int(memo[DONE])
    end = Continuation(
        start.first + done, read_only(state), read_only(stages), memo, start.solver, start.tolerance
    )
    shape = problem.q0.shape
    states = saved.reshape(2, len(kept), *shape)
    t_first = problem.t0 + start.first * step
    return Trajectory(
        problem=problem,
        t=read_only(problem.t0 + (start.first + np.array(kept)) * step),
        q=read_only(states[0]),
        p=read_only(problem.system.momentum(states[1])),
        success=done == steps,
        status=_status(code, done, steps, t_first + done * step),
        failed_step=None if done == steps else done + 1,
        counts=_counts(problem, field, done, counts),
        step=step,
        method=method,
        curves=Curves(method.space, t_first, step, read_only(bases), read_only(coefficients), shape)
        if with_curves
        else None,
        continuation=end,
    )


def kernel_tableau(method: Galerkin) -> tuple[Array, ...]:
    """The method's table in the order and layout of galvi.kernels.step."""
    table = method.table

    def turned(matrix: Array) -> Array:
        return read_only(matrix.T)

    return (
        table.c, table.b, table.beta, turned(table.A), turned(table.psi), table.lead, table.C,
        turned(table.C), turned(table.analysis), turned(table.ahead), table.growth,
    )  # fmt: skip


def path_of_smaller_steps(
    problem: Problem, method: Galerkin, step: float, t: float, state: Array, counts: Any
) -> Array | None:
    """Accelerations (d, s) along a run from (t, state) with 4, 16, 64 or 256 steps in one.

    None when none of them can be solved by fixed-point iteration. Adds its cost to ``counts``.
    """
    shape = problem.q0.shape
    here = Problem(problem.system, state[0].reshape(shape), state[2].reshape(shape), t)
    for parts in SUBSTEPS:
        start = Continuation.at_start(here, method.stages, "fixed_point", 1e-8)
        run = march(here, method, step / parts, parts, start, rescue=False)
        counts[:2] += run.counts["iterations"], run.counts["force_evaluations"]
        if run.success:
            times = t + method.table.c * step
            path = run(times)
            counts[1] += len(times)
            rows = [problem.system.acceleration(q, s) for q, s in zip(path, times, strict=True)]
            return np.ascontiguousarray(np.stack(rows).reshape(len(times), -1).T)
    return None


def _status(code: int, done: int, steps: int, t: float) -> str:
    if done == steps:
        return COMPLETED
    where = f"at step {done + 1} of {steps}, from t = {t:g}"
    if code == SOLVED:
        return f"Interrupted {where}; what was computed is kept."
    if code == NOT_FINITE:
        return (
            f"Stopped {where}: the force or the state became infinite or NaN. "
            f"Use a smaller step, or look for a collision."
        )
    return (
        f"Stopped {where}: neither fixed-point iteration nor Newton's method solved the stage "
        f"equations. Use a smaller step or a higher degree."
    )


def _counts(problem: Problem, field: Field, done: int, counts: Any) -> dict[str, int]:
    iterations, forces, hessians, solves = (int(count) for count in counts)
    result = {
        "steps": done,
        "iterations": iterations,
        "force_evaluations": forces,
        "hessian_evaluations": hessians,
        "linear_solves": solves,
    }
    differenced = getattr(problem.system, "potential_calls_per_force", 0)
    if differenced:
        result["potential_evaluations"] = forces * differenced * problem.q0.size
    return result
