"""Many steps of a canonical system: predict, solve, complete, record.

state   (4, d)   see galvi.kernels.nystrom.step
a       (d, s)   accelerations at the last step's stages, the next prediction's source
memo    (3,)     [what a holds: NOTHING, LAST_STEP or GUESS; steps to start with Newton; done]
counts  (5,)     iterations, force and Hessian evaluations, linear solves, see
        galvi.kernels.nystrom.solve
saved_q, saved_v (saved, d)   rows 1, 2, ... are steps every, 2 every, ...; the last row is the end
bases, curves    (steps, d), (steps, d, m)   or no rows, when curves are not kept
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import MATRIX, TENSOR3, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit, jit_inline
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED, solve
from galvi.kernels.nystrom.step import (
    all_finite,
    complete_step,
    copy_into,
    curve_coefficients,
    predict,
)

NOTHING, LAST_STEP, GUESS = 0, 1, 2
HOLDS, STREAK, DONE = 0, 1, 2


@jit_inline
def keep(tableau, h, every, step, total, before, state, a, saved_q, saved_v, bases, curves):
    """Store what is kept of the (step + 1)-th step, from the state before to the state after."""
    row, rest = divmod(step + 1, every)
    if step + 1 == total:
        row, rest = saved_q.shape[0] - 1, 0
    if rest == 0:
        for i in range(state.shape[1]):
            saved_q[row, i] = state[0, i]
            saved_v[row, i] = state[2, i]
    if bases.shape[0] > 0:
        for i in range(state.shape[1]):
            bases[step, i] = before[0, i]
        curve_coefficients(tableau, h, before, a, curves[step])


@jit
def commit(tableau, h, every, step, total, streak, work, state, a, memo, saved_q, saved_v, bases,
           curves):  # fmt: skip
    """Complete the (step + 1)-th step and store what is kept of it, all or nothing."""
    before = np.empty(state.shape)
    copy_into(before, state)
    complete_step(tableau, h, work, state)
    if not all_finite(state):
        copy_into(state, before)
        return False
    copy_into(a, work)
    memo[HOLDS], memo[STREAK], memo[DONE] = LAST_STEP, streak, step + 1
    keep(tableau, h, every, step, total, before, state, a, saved_q, saved_v, bases, curves)
    return True


@jit
def advance(kind, functions, has_hessian, constants, inverse_mass, width, tableau, t0, h, solver,
            tolerance, first, todo, total, every, state, a, memo, counts, saved_q, saved_v, bases,
            curves):  # fmt: skip
    """Do ``todo`` more steps of a run that started at step number ``first``; returns a code.

    memo[DONE] says how many were done; a step that cannot be solved leaves the state where it was.
    """
    c = tableau[0]
    d, s = a.shape
    Q = np.empty((d, s))
    work = np.empty((d, s))
    t = np.empty(s)
    for step in range(memo[DONE], memo[DONE] + todo):
        for k in range(s):
            t[k] = t0 + ((first + step) + c[k]) * h
        if memo[HOLDS] == LAST_STEP:
            predict(tableau, a, work)
        elif memo[HOLDS] == GUESS:
            copy_into(work, a)
        else:
            work = np.zeros((d, s))
        code, streak = solve(
            kind, functions, has_hessian, constants, inverse_mass, width, tableau, h, t, state,
            solver, tolerance, memo[STREAK], counts, work, Q,
        )  # fmt: skip
        if code != SOLVED:
            return code
        if not commit(
            tableau, h, every, step, total, streak, work, state, a, memo, saved_q, saved_v, bases,
            curves,
        ):  # fmt: skip
            return NOT_FINITE
    return SOLVED


_FIXED = types.Array(types.float64, 1, "C", readonly=True)
_FIXED_MATRIX = types.Array(types.float64, 2, "C", readonly=True)
TABLEAU = types.Tuple(
    (_FIXED, _FIXED, _FIXED, _FIXED_MATRIX, _FIXED_MATRIX, _FIXED, _FIXED_MATRIX, _FIXED_MATRIX,
     _FIXED_MATRIX, _FIXED_MATRIX, _FIXED)
)  # fmt: skip


@cache
def compiled_advance():
    """``advance`` compiled for every system at once, from the cache on disk where there is one."""
    whole, real = types.int64, types.float64
    wholes = types.int64[::1]
    signature = whole(
        whole, wholes, types.boolean,
        VECTOR, MATRIX, whole, TABLEAU, real, real, whole, real, whole, whole, whole,
        whole, MATRIX, MATRIX, wholes, wholes, MATRIX, MATRIX,
        MATRIX, TENSOR3,
    )  # fmt: skip
    return compiled_for(advance, signature)
