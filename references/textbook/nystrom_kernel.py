"""The compiled loop of an explicit Nystrom method; notation as in `references.textbook.nystrom`.

A (s, s), c (s,)          stages and nodes
bq, bv (s,)               weights of the accelerations in the position and the velocity
q, v (d,)                 state, advanced in place
F (s, d)                  accelerations at the stages; the last row carries over when `reuses_last`
first, last, total        steps done, to be done in this call, in the whole run
saved_q, saved_v (n, d)   states kept: every `every` steps and the last
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numba import types

from galvi.kernels.compile import interpreted as interpretation
from galvi.kernels.compile.array_types import MATRIX, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.forces.accelerations import accelerations

STATE, ROWS, WHOLE, REAL = VECTOR, MATRIX, types.int64, types.float64
SIGNATURE = types.UniTuple(WHOLE, 2)(
    ROWS, STATE, STATE, STATE, types.boolean, WHOLE, types.int64[::1], STATE, ROWS, STATE, STATE,
    ROWS, REAL, REAL, WHOLE, WHOLE, WHOLE, WHOLE, ROWS, ROWS,
)  # fmt: skip


@jit
def advance(
    A, c, bq, bv, reuses_last, kind, functions, constants, inverse_mass, q, v, F, t0, h, first,
    last, total, every, saved_q, saved_v,
):  # fmt: skip
    """Steps first .. last; returns the number of the step that failed (0: none) and evaluations."""
    d = q.size
    stages = c.size
    Q = np.empty((d, 1))
    a = np.empty((d, 1))
    t = np.empty(1)
    evaluations = 0
    for k in range(first, last):
        for s in range(stages):
            if s == 0 and reuses_last and k > 0:
                F[0, :] = F[stages - 1, :]
                continue
            for i in range(d):
                pulled = 0.0
                for j in range(s):
                    pulled += A[s, j] * F[j, i]
                Q[i, 0] = q[i] + h * (c[s] * v[i] + h * pulled)
            t[0] = t0 + (k + c[s]) * h
            accelerations(kind, functions, constants, inverse_mass, Q, t, a)
            evaluations += 1
            for i in range(d):
                F[s, i] = a[i, 0]
        residue = 0.0
        for i in range(d):
            moved = 0.0
            kicked = 0.0
            for s in range(stages):
                moved += bq[s] * F[s, i]
                kicked += bv[s] * F[s, i]
            q[i] += h * (v[i] + h * moved)
            v[i] += h * kicked
            residue += (q[i] - q[i]) + (v[i] - v[i])
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1, evaluations
        if (k + 1) % every == 0 or k + 1 == total:
            row = (k + every) // every
            saved_q[row, :] = q
            saved_v[row, :] = v
    return 0, evaluations


@cache
def compiled() -> Callable[..., Any]:
    """One compilation, kept on disk, for every law and every user's jitted function."""
    source: Any = advance
    kernel: Callable[..., Any] = compiled_for(source, SIGNATURE)
    return kernel


@cache
def interpreted() -> Callable[..., Any]:
    """The same source run by the interpreter, for forces that cannot be compiled."""
    return interpretation.interpreted(advance)
