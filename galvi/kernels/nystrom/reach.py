"""States between the steps of a run: whole steps and a shortened one, from many states."""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import TENSOR3, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.nystrom.solve import FORCE, NOT_FINITE, SOLVED, Force, solve
from galvi.kernels.nystrom.step import (
    TABLEAU,
    NystromTableau,
    all_finite,
    complete_step,
    copy_into,
    predict,
)


@jit
def reach(force, tableau, solver, tolerance, step, begin, whole, rest, states, stages, codes):
    """Do whole[k] steps of ``step`` and one of rest[k], unless that is 0, from each of n states.

    begin  (n,) times of the states (n, 4, d), see galvi.kernels.nystrom.step, which are advanced
    stages (n, d, s) accelerations from which the last step's iteration starts, and with which it
           ends
    codes  (n,) <- the code of the step that failed, 0 for none
    """
    force, tableau = Force(*force), NystromTableau(*tableau)
    n, d, s = stages.shape
    Q, work, a, t = np.empty((d, s)), np.empty((d, s)), np.zeros((d, s)), np.empty(s)
    counts = np.zeros(8, dtype=np.int64)
    for row in range(n):
        state, streak, code = states[row], 0, SOLVED
        for k in range(whole[row] + 1):
            last = k == whole[row]
            h = rest[row] if last else step
            if h == 0.0:
                break
            for j in range(s):
                t[j] = begin[row] + k * step + tableau.c[j] * h
            if last:
                copy_into(work, stages[row])
            elif k == 0:
                work = np.zeros((d, s))
            else:
                predict(tableau, a, work)
            code, streak = solve(
                force, tableau, h, t, state, solver, tolerance, streak, counts, work, Q
            )
            if code == SOLVED:
                complete_step(tableau, h, work, state)
                code = SOLVED if all_finite(state) else NOT_FINITE
            if code != SOLVED:
                break
            copy_into(stages[row] if last else a, work)
        codes[row] = code


@cache
def compiled_reach():
    """``reach`` compiled or cached, one kernel for all systems."""
    whole = types.int64
    numbers = whole[::1]
    return compiled_for(reach, types.void(
        FORCE, TABLEAU, whole, types.float64, types.float64, VECTOR, numbers, VECTOR, TENSOR3,
        TENSOR3, numbers,
    ))  # fmt: skip
