"""Many steps of a canonical system: predict, solve, complete, record.

state         (4, d)   see galvi.kernels.nystrom.step
a             (d, s)   accelerations at the last step's stages, from which the next is predicted
solver_state  (3,)     content of a (NOTHING, LAST_STEP or GUESS), number of steps that start with
                       Newton's method, number of steps done; indices HOLDS, STREAK and DONE
passage       (p,)     see galvi.kernels.forces.passages, for point masses; (0,) for other systems
counts        (7,)     iterations, force and Hessian evaluations, linear solves, pair evaluations;
                       see galvi.kernels.nystrom.solve
"""

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import TENSOR3, VECTOR, compiled_for, jit
from galvi.kernels.forces.passages import note_passages
from galvi.kernels.nystrom import step as steps
from galvi.kernels.nystrom.solve import FORCE, NOT_FINITE, SOLVED, Force, solve
from galvi.kernels.nystrom.step import TABLEAU
from galvi.kernels.run_record import PLAN, PROGRESS, RECORDING, Plan, Progress, Recording, record

NOTHING, LAST_STEP, GUESS = 0, 1, 2
HOLDS, STREAK, DONE = 0, 1, 2


@jit
def commit(tableau, plan, step, streak, work, progress, recording, before):
    """Complete the (step + 1)-th step and record it.

    before (4, d) is set to the state at the start of the step. Returns False if the state at the
    end is not finite; the run is then unchanged.
    """
    state, h = progress.state, plan.step
    steps.copy_into(before, state)
    steps.complete_step(tableau, h, work, state)
    if not steps.all_finite(state):
        steps.copy_into(state, before)
        return False
    steps.copy_into(progress.stages, work)
    solver_state = progress.solver_state
    solver_state[HOLDS], solver_state[STREAK], solver_state[DONE] = LAST_STEP, streak, step + 1
    record(plan, recording, step, before[0], state[0], state[2])
    if recording.bases.shape[0] > 0:
        steps.curve_coefficients(tableau, h, before, work, recording.curves[step])
    return True


@jit
def advance(force, tableau, plan, solver, todo, progress, recording):
    """Do ``todo`` more steps of a run; returns SOLVED, or the code of the step that failed.

    solver_state[DONE] counts the steps. A step that fails leaves the state unchanged.
    """
    force, tableau = Force(*force), steps.NystromTableau(*tableau)
    plan, progress, recording = Plan(*plan), Progress(*progress), Recording(*recording)
    state, a, solver_state, h = progress.state, progress.stages, progress.solver_state, plan.step
    d, s = a.shape
    Q = np.empty((d, s))
    work = np.empty((d, s))
    t, before = np.empty(s), np.empty(state.shape)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for k in range(s):
            t[k] = plan.t0 + ((plan.first + step) + tableau.c[k]) * h
        if solver_state[HOLDS] == LAST_STEP:
            steps.predict(tableau, a, work)
        elif solver_state[HOLDS] == GUESS:
            steps.copy_into(work, a)
        else:
            work = np.zeros((d, s))
        code, streak = solve(
            force,
            tableau,
            h,
            t,
            state,
            solver,
            plan.tolerance,
            solver_state[STREAK],
            progress.counts,
            work,
            Q,
        )
        if code != SOLVED:
            return code
        if not commit(tableau, plan, step, streak, work, progress, recording, before):
            return NOT_FINITE
        if progress.passage.size > 0:
            note_passages(
                progress.passage,
                Q,
                tableau.c,
                before[0],
                state[0],
                h,
                tableau.velocity_coefficients.size,
                np.inf,
                plan.first + step + 1,
            )
    return SOLVED


@cache
def compiled_advance():
    """The compiled ``advance``, one kernel for all systems."""
    integer = types.int64
    return compiled_for(
        advance, integer(FORCE, steps.TABLEAU, PLAN, integer, integer, PROGRESS, RECORDING)
    )


UNWATCHED = 62  # `Plan.watch` for no watched steps: 2^62 steps from one to the next


@jit
def advance_states(
    force, tableau, solver, tolerance, step, begin, full_steps, last_step, states, stages, codes
):
    """Advance each state by full_steps[k] steps of ``step`` and, unless it is 0, one of
    last_step[k].

    Parameters
    ----------
    begin : array, shape (n,)
        times of the states
    states : array, shape (n, 4, d)
        see galvi.kernels.nystrom.step; they are replaced
    stages : array, shape (n, d, s)
        accelerations from which the iteration of the last step starts, and at which it ends
    codes : array, shape (n,)
        set to the code of the step that failed, SOLVED if none did
    """
    empty, counts, solver_state = np.zeros((1, 0)), np.zeros(8, np.int64), np.zeros(3, np.int64)
    unrecorded = (empty, empty, empty[:0], np.zeros((0, 0, 0)), empty[:0])
    for k in range(codes.size):
        solver_state[:], n, code = 0, full_steps[k], SOLVED
        if n > 0:
            plan = (begin[k], step, tolerance, 0, n, n, UNWATCHED)
            progress = (states[k], np.zeros(stages[k].shape), solver_state, counts, empty[0])
            code = advance(force, tableau, plan, solver, n, progress, unrecorded)
        if code == SOLVED and last_step[k] != 0.0:
            solver_state[HOLDS], solver_state[DONE] = GUESS, 0
            plan = (begin[k] + n * step, last_step[k], tolerance, 0, 1, 1, UNWATCHED)
            progress = (states[k], stages[k], solver_state, counts, empty[0])
            code = advance(force, tableau, plan, solver, 1, progress, unrecorded)
        codes[k] = code


@cache
def compiled_advance_states():
    """The compiled ``advance_states``, one kernel for all systems."""
    integer = types.int64
    numbers = integer[::1]
    return compiled_for(advance_states, types.void(
        FORCE, TABLEAU, integer, types.float64, types.float64, VECTOR, numbers, VECTOR, TENSOR3,
        TENSOR3, numbers,
    ))  # fmt: skip
