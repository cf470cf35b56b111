"""Many steps of a canonical system: `galvi.kernels.nystrom.advance` in vector instructions.

Method, prediction, stopping rule and compensated updates are the same; a step that fixed-point
iteration cannot solve is left to the general kernel.

law           (1,)     address of galvi.fast.lanes.force_pass for the potential
constants     (c,)     its constants
tables                 as in galvi.fast.lanes.nbody
work          (6, d, P)  stages, last accelerations, h c v, its low part, scratch, new accelerations
spare         (6, at least d, P and 4)  state before the step, the iteration's history, times
solver_state  (4,)     as in the general kernel, then the number of Legendre terms extrapolated
"""

from __future__ import annotations

from functools import cache

from numba import types

from galvi.fast.lanes.gravity import LANES, drift, fused, move
from galvi.fast.lanes.law import FOUR, ONE, gather, terms_of
from galvi.fast.lanes.nbody import GRAVITY_TABLES, RECONSIDER, copy_rows, end_of_step
from galvi.kernels.compile.array_types import MATRIX, TENSOR3, VECTOR
from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import compiled_for, jit_inline
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP, STREAK
from galvi.kernels.nystrom.solve import (
    DIVERGED,
    FIXED_POINT_PASSES,
    FORCES,
    GOING,
    ITERATIONS,
    NOT_FINITE,
    SOLVED,
    reset_history,
    verdict,
)
from galvi.kernels.nystrom.step import (
    TABLEAU,
    NystromTableau,
    copy_into,
    curve_coefficients,
)
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, record

TERMS = 3  # index in solver_state


@jit_inline
def move_rows(moves, start, stages, a, base, low, state, Q, size):
    """Q <- q + (base + (low + h^2 A a)); returns the largest change times ``size``."""
    (d, padded), change = Q.shape, 0.0
    for chunk in range(padded // LANES):
        for block in range(d // 4):
            change = move(
                FOUR, moves, start, a, base, low, state, Q, change, size, block, stages, padded,
                chunk,
            )  # fmt: skip
        for i in range(d - d % 4, d):
            change = move(
                ONE, moves, start, a, base, low, state, Q, change, size, i, stages, padded, chunk
            )
    return change


@jit_inline
def place(ahead, s, c, h, terms, state, a, base, low, Q):
    """The start of a step: base, low and first stages Q; returns the largest |q|, |q + h v|.

    a holds the last step's accelerations, or the guess itself if ``terms`` is 0.
    """
    gather(ahead, (2 * terms + 1) * s, s, a, low)
    size = 0.0
    for i in range(Q.shape[0]):
        far = h * state[2, i]
        far_low = fused(h, state[2, i], -far) + h * state[3, i]
        for chunk in range(Q.shape[1] // LANES):
            drift(c, base, low, i, far, far_low, state[1, i], Q.shape[1], chunk)
        size = max(size, abs(state[0, i]), abs(state[0, i] + far))
    move_rows(ahead, 2 * terms * s, s, a, base, low, state, Q, 0.0)
    return size


@jit_inline
def iterate(law, constants, moves, s, state, base, low, size, tolerance, counts, Q, a, t, history):
    """Fixed-point iteration from stages Q until convergence; returns a code.

    A motion from rest at the origin is measured by its size after the first pass.
    """
    reset_history(history)
    scale = 1.0 / size if size > 0.0 else 0.0
    for passes in range(FIXED_POINT_PASSES):
        call_void(law[0], Q, t, constants, a)
        change = move_rows(moves, 0, s, a, base, low, state, Q, scale)
        counts[ITERATIONS] += 1
        counts[FORCES] += s
        if passes == 0 and size == 0.0:
            for i in range(Q.shape[0]):
                for k in range(s):
                    size = max(size, abs(Q[i, k]))
            scale = 1.0 / size if size > 0.0 else 0.0
            continue
        code = verdict(change, tolerance, history)
        if code != GOING:
            return code
    return DIVERGED


@jit_inline
def advance_canonical(
    law, constants, tableau, tables, plan, todo, progress, work, spare, kept
):  # fmt: skip
    """Do ``todo`` more steps of a run; returns a code, as the general kernel."""
    tableau, plan, kept = NystromTableau(*tableau), Plan(*plan), Kept(*kept)
    ahead, series, growth, sums, c = tables
    state, stages, solver_state, counts, _passage = progress
    h, s, d = plan.step, series.shape[0], state.shape[1]
    Q, a, base, low, scratch, new = work[0], work[1], work[2], work[3], work[4], work[5]
    before, history, t = spare[:4, :d], spare[4, :4], spare[5, : Q.shape[1]]
    copy_rows(a, stages)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        if solver_state[STREAK] > 0:
            copy_rows(stages, a)
            return DIVERGED
        for k in range(t.size):
            t[k] = plan.t0 + ((plan.first + step) + c[0, k]) * h
        copy_into(before, state)
        if solver_state[HOLDS] != LAST_STEP:
            solver_state[TERMS] = 0
        elif (plan.first + step) % RECONSIDER == 0 or solver_state[TERMS] == 0:
            solver_state[TERMS] = terms_of(series, growth, a, scratch, new[0, :s])
        size = place(ahead, s, c, h, solver_state[TERMS], state, a, base, low, Q)
        code = iterate(
            law, constants, ahead, s, state, base, low, size, plan.tolerance, counts, Q, new, t,
            history,
        )  # fmt: skip
        if code == SOLVED:
            gather(sums, 0, s, new, scratch)
            if not end_of_step(h, scratch, state):
                code = NOT_FINITE
        if code != SOLVED:
            copy_into(state, before)
            copy_rows(stages, a)
            return code
        a, new = new, a
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, before[0], state[0], state[2])
        if kept.bases.shape[0] > 0:
            copy_rows(stages, a)
            curve_coefficients(tableau, h, before, stages, kept.curves[step])
    copy_rows(stages, a)
    return SOLVED


@cache
def compiled_advance_canonical():
    """``advance_canonical`` compiled or cached, one kernel for all potentials."""
    whole = types.int64
    signature = whole(
        types.int64[::1], VECTOR, TABLEAU, GRAVITY_TABLES, PLAN, whole, PROGRESS, TENSOR3, MATRIX,
        KEPT,
    )  # fmt: skip
    return compiled_for(advance_canonical, signature, jit_inline)
