"""The compiled loop of an explicit Nystrom method; notation as in `references.textbook.nystrom`.

A (s, s), c (s,)          stages and nodes
bq, bv (s,)               weights of the accelerations in the position and the velocity
force, numbers            force(q, v, t, numbers, out), see `references.forces.force`
inverse_mass              (d, 1) diagonal or (d, d)
q, v (d,)                 state, advanced in place
F (s, d)                  accelerations at the stages; the last row carries over when `reuses_last`
Q, f (d,)                 scratch: the configuration at a stage and the force there
first, last, total        steps done, to be done in this call, in the whole run
saved_q, saved_v (n, d)   states kept: every `every` steps and the last

The force gets the velocity of the step's start, so only one-stage methods may depend on it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from numba import types

from references.compiled import njit
from references.forces.force import FUNCTION, OPTIONS, VECTOR

MATRIX, WHOLE, REAL = types.float64[:, ::1], types.int64, types.float64
SIGNATURE = types.UniTuple(WHOLE, 2)(
    MATRIX, VECTOR, VECTOR, VECTOR, types.boolean, FUNCTION, VECTOR, MATRIX, VECTOR, VECTOR,
    MATRIX, VECTOR, VECTOR, REAL, REAL, WHOLE, WHOLE, WHOLE, WHOLE, MATRIX, MATRIX,
)  # fmt: skip


def advance(
    A, c, bq, bv, reuses_last, force, numbers, inverse_mass, q, v, F, Q, f, t0, h, first, last,
    total, every, saved_q, saved_v,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Steps first .. last; returns the number of the step that failed (0: none) and evaluations."""
    d, stages = q.size, c.size
    evaluations = 0
    for k in range(first, last):
        for s in range(stages):
            if s == 0 and reuses_last and k > 0:
                for i in range(d):
                    F[0, i] = F[stages - 1, i]
                continue
            starts = s == 0 and c[0] == 0.0  # the stage is the start of the step
            for i in range(0 if starts else d):
                change = 0.0
                for j in range(s):
                    change += A[s, j] * F[j, i]
                Q[i] = q[i] + h * (c[s] * v[i] + h * change)
            f[:] = 0.0
            force(q if starts else Q, v, t0 + (k + c[s]) * h, numbers, f)
            evaluations += 1
            if inverse_mass.shape[1] == 1:
                for i in range(d):
                    F[s, i] = inverse_mass[i, 0] * f[i]
            else:
                for i in range(d):
                    F[s, i] = 0.0
                    for j in range(d):
                        F[s, i] += inverse_mass[i, j] * f[j]
        residue = 0.0
        for i in range(d):
            moved = bq[0] * F[0, i]
            kicked = bv[0] * F[0, i]
            for s in range(1, stages):
                moved += bq[s] * F[s, i]
                kicked += bv[s] * F[s, i]
            q[i] += h * (v[i] + h * moved)
            v[i] += h * kicked
            residue += (q[i] - q[i]) + (v[i] - v[i])
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1, evaluations
        if (k + 1) % every == 0 or k + 1 == total:
            row = (k + every) // every
            for i in range(d):
                saved_q[row, i], saved_v[row, i] = q[i], v[i]
    return 0, evaluations


@cache
def compiled() -> Callable[..., Any]:
    """One compilation, kept on disk, for every formula and every user's jitted functions."""
    kernel: Callable[..., Any] = njit(SIGNATURE, _nrt=False, **OPTIONS)(advance)
    return kernel
