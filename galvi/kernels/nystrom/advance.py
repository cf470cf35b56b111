"""Many steps of a canonical system: predict, solve, complete, record.

state         (4, d)   see galvi.kernels.nystrom.step
a             (d, s)   accelerations at the last step's stages, from which the next is predicted
solver_state  (3,)     [content of a: NOTHING, LAST_STEP or GUESS; steps to start with Newton; done]
passage       (5,)     see galvi.kernels.forces.passages, for point masses; (0,) for other systems
counts        (8,)     iterations, force and Hessian evaluations, linear solves, pair evaluations;
                       see galvi.kernels.nystrom.solve
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.forces.passages import note_passages
from galvi.kernels.nystrom import step as steps
from galvi.kernels.nystrom.solve import FORCE, NOT_FINITE, SOLVED, Force, solve
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, Progress, record

NOTHING, LAST_STEP, GUESS = 0, 1, 2
HOLDS, STREAK, DONE = 0, 1, 2


@jit
def commit(tableau, plan, step, streak, work, progress, kept, before):
    """Complete the (step + 1)-th step and record it; False, with nothing changed, if not finite.

    before (4, d) <- the state at the start of the step
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
    record(plan, kept, step, before[0], state[0], state[2])
    if kept.bases.shape[0] > 0:
        steps.curve_coefficients(tableau, h, before, work, kept.curves[step])
    return True


@jit
def advance(force, tableau, plan, solver, todo, progress, kept):
    """Do ``todo`` more steps of a run; returns a code.

    solver_state[DONE] counts the steps done; a step that cannot be solved leaves the state
    unchanged.
    """
    force, tableau = Force(*force), steps.NystromTableau(*tableau)
    plan, progress, kept = Plan(*plan), Progress(*progress), Kept(*kept)
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
            force, tableau, h, t, state, solver, plan.tolerance, solver_state[STREAK],
            progress.counts, work, Q,
        )  # fmt: skip
        if code != SOLVED:
            return code
        if not commit(tableau, plan, step, streak, work, progress, kept, before):
            return NOT_FINITE
        if progress.passage.size > 0:  # constants as in galvi.kernels.forces.nbody
            note_passages(
                force.constants[1 : 1 + state.shape[1] // int(force.constants[0])],
                int(force.constants[0]), Q, tableau.c, before[0], state[0], h,
                tableau.velocity_coefficients.size, np.inf, plan.first + step + 1,
                progress.passage,
            )  # fmt: skip
    return SOLVED


@cache
def compiled_advance():
    """``advance`` compiled or cached, one kernel for all systems."""
    whole = types.int64
    return compiled_for(advance, whole(FORCE, steps.TABLEAU, PLAN, whole, whole, PROGRESS, KEPT))
