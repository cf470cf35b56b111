"""States between the steps of a run: whole steps and a shortened one, from many states."""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import TENSOR3, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.nystrom.advance import DONE, GUESS, HOLDS, advance
from galvi.kernels.nystrom.solve import FORCE, SOLVED
from galvi.kernels.nystrom.step import TABLEAU

NEVER = 62  # 2^62 steps between those that are watched


@jit
def reach(force, tableau, solver, tolerance, step, begin, whole, rest, states, stages, codes):
    """Do whole[k] steps of ``step`` and one of rest[k], unless that is 0, from each of n states.

    begin  (n,) times of the states (n, 4, d), see galvi.kernels.nystrom.step, which are advanced
    stages (n, d, s) accelerations from which the last step's iteration starts, and with which it
           ends
    codes  (n,) <- the code of the step that failed, 0 for none
    """
    none, counts, holds = np.zeros((1, 0)), np.zeros(8, np.int64), np.zeros(3, np.int64)
    kept = (none, none, none[:0], np.zeros((0, 0, 0)), none[:0])
    for k in range(codes.size):
        holds[:], n, code = 0, whole[k], SOLVED
        if n > 0:
            plan = (begin[k], step, tolerance, 0, n, n, NEVER)
            progress = (states[k], np.zeros(stages[k].shape), holds, counts, none[0])
            code = advance(force, tableau, plan, solver, n, progress, kept)
        if code == SOLVED and rest[k] != 0.0:
            holds[HOLDS], holds[DONE] = GUESS, 0
            plan = (begin[k] + n * step, rest[k], tolerance, 0, 1, 1, NEVER)
            progress = (states[k], stages[k], holds, counts, none[0])
            code = advance(force, tableau, plan, solver, 1, progress, kept)
        codes[k] = code


@cache
def compiled_reach():
    """``reach`` compiled or cached, one kernel for all systems."""
    whole = types.int64
    numbers = whole[::1]
    return compiled_for(reach, types.void(
        FORCE, TABLEAU, whole, types.float64, types.float64, VECTOR, numbers, VECTOR, TENSOR3,
        TENSOR3, numbers,
    ))  # fmt: skip
