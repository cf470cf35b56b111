"""The compiled loops of RK4 and DOP853 for a rigid body, in quaternions and body momentum.

s        (7,) tuple: quaternion w, x, y, z of the turn since the start, momentum along the
         principal axes
inverse  (3,) of the principal moments
force    (3,) mass g, in the frame of the start;  centre (3,) of mass;  heavy: whether they act
state    (7,) advanced in place
saved    (n, 7) states kept: every `every` steps and the last

The quaternion is divided by its norm after each accepted step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numba import types

from references.compiled import njit
from references.forces.force import OPTIONS

jit: Any = njit(**OPTIONS)
WHOLE, REAL = types.int64, types.float64
ROW, ROWS = types.float64[::1], types.float64[:, ::1]
TURNING = (ROW, ROW, ROW, types.boolean, ROW)
RK4_SIGNATURE = types.int64(*TURNING, REAL, WHOLE, WHOLE, WHOLE, WHOLE, ROWS)
DOP853_SIGNATURE = types.UniTuple(WHOLE, 3)(*TURNING, ROWS, ROW, ROW, REAL, REAL, ROW, WHOLE)
STAGES = 12
SAFETY, LEAST, MOST, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0
EPS = 2.0**-52


@jit
def slopes(s, inverse, force, centre, heavy):
    """The derivative s' (7,) of a state with a quaternion of norm 1."""
    w, x, y, z, a, b, c = s
    u, v, r = inverse[0] * a, inverse[1] * b, inverse[2] * c
    da, db, dc = b * r - c * v, c * u - a * r, a * v - b * u
    if heavy:
        f, g, k = force
        up = 2.0 * (x * f + y * g + z * k)
        still = w * w - (x * x + y * y + z * z)
        i = still * f + up * x + 2.0 * w * (g * z - k * y)
        j = still * g + up * y + 2.0 * w * (k * x - f * z)
        l = still * k + up * z + 2.0 * w * (f * y - g * x)
        da += centre[1] * l - centre[2] * j
        db += centre[2] * i - centre[0] * l
        dc += centre[0] * j - centre[1] * i
    return (
        -0.5 * (x * u + y * v + z * r),
        0.5 * (w * u + y * r - z * v),
        0.5 * (w * v + z * u - x * r),
        0.5 * (w * r + x * v - y * u),
        da,
        db,
        dc,
    )


@jit
def moved(s, h, k):
    """s + h k."""
    return (
        s[0] + h * k[0],
        s[1] + h * k[1],
        s[2] + h * k[2],
        s[3] + h * k[3],
        s[4] + h * k[4],
        s[5] + h * k[5],
        s[6] + h * k[6],
    )


@jit
def normalised(s):
    """The same state with a quaternion of norm 1."""
    shrunk = 1.0 / np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
    return (s[0] * shrunk, s[1] * shrunk, s[2] * shrunk, s[3] * shrunk, s[4], s[5], s[6])


@jit
def loaded(row):
    """Seven numbers of a row as a tuple."""
    return (row[0], row[1], row[2], row[3], row[4], row[5], row[6])


@jit
def store(s, row):
    """row <- s."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = s


@jit
def rk4(inverse, force, centre, heavy, state, h, first, last, total, every, saved):
    """Steps first .. last of the whole; returns the number of the step that failed (0: none)."""
    body = (
        (inverse[0], inverse[1], inverse[2]),
        (force[0], force[1], force[2]),
        (centre[0], centre[1], centre[2]),
        heavy,
    )
    s = loaded(state)
    for k in range(first, last):
        a = slopes(s, *body)
        b = slopes(moved(s, 0.5 * h, a), *body)
        c = slopes(moved(s, 0.5 * h, b), *body)
        d = slopes(moved(s, h, c), *body)
        s = moved(moved(moved(moved(s, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d)
        s = normalised(s)
        residue = (s[0] - s[0]) + (s[4] + s[5] + s[6]) * 0.0
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1
        if (k + 1) % every == 0 or k + 1 == total:
            store(s, saved[(k + every) // every])
    store(s, state)
    return 0


@jit
def weighted(s, h, K, row, stages):
    """s + h sum_j row_j K_j."""
    for j in range(stages):
        if row[j] != 0.0:
            s = moved(s, h * row[j], loaded(K[j]))
    return s


@jit
def error_of(s, new, h, K, E3, E5, rtol, atol):
    """The step's estimated error over its tolerance (Hairer, Norsett and Wanner I, II.10)."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    third, fifth = weighted(zero, 1.0, K, E3, STAGES), weighted(zero, 1.0, K, E5, STAGES)
    low = high = 0.0
    for i in range(7):
        scale = atol + rtol * max(abs(s[i]), abs(new[i]))
        low += (third[i] / scale) ** 2
        high += (fifth[i] / scale) ** 2
    if high == 0.0:
        return 0.0
    return abs(h) * high / np.sqrt(7.0 * (high + 0.01 * low))


@jit
def dop853(
    inverse, force, centre, heavy, state, A, E3, E5, rtol, atol, clock, budget,
):  # fmt: skip
    """Up to `budget` tried steps to clock[1]; returns 0 done, 1 more to do, -1 failed; the tries
    and the steps.

    A (13, 12), the last row the weights; clock (3,) time, where to end, next step: changed in place
    """
    body = (
        (inverse[0], inverse[1], inverse[2]),
        (force[0], force[1], force[2]),
        (centre[0], centre[1], centre[2]),
        heavy,
    )
    K = np.empty((STAGES, 7))
    s, grown, accepted = loaded(state), MOST, 0
    t, end, wanted = clock[0], clock[1], clock[2]
    store(slopes(s, *body), K[0])
    for tried in range(budget):
        left = end - t
        ends = abs(wanted) >= abs(left)
        h = left if ends else wanted
        if not (ends or abs(h) > 10.0 * EPS * abs(end)):
            return -1, tried, accepted
        for j in range(1, STAGES):
            store(slopes(weighted(s, h, K, A[j], j), *body), K[j])
        new = weighted(s, h, K, A[STAGES], STAGES)
        error = error_of(s, new, h, K, E3, E5, rtol, atol)
        if error <= 1.0:
            factor = min(grown, max(LEAST, SAFETY * error**EXPONENT)) if error > 0.0 else grown
            wanted = max(abs(wanted), abs(h * factor)) * np.sign(h) if ends else h * factor
            s, grown = normalised(new), MOST
            t = end if ends else t + h
            accepted += 1
            store(s, state)
            clock[0], clock[2] = t, wanted
            if ends:
                return 0, tried + 1, accepted
            store(slopes(s, *body), K[0])
        else:  # NaN comes here too
            factor = max(LEAST, SAFETY * error**EXPONENT) if error > 0.0 else LEAST
            wanted, grown = h * factor, 1.0
    clock[2] = wanted
    return 1, budget, accepted


@cache
def compiled(name: str) -> Callable[..., Any]:
    """'rk4' or 'dop853', compiled once and kept on disk."""
    sources: dict[str, Any] = {"rk4": (rk4, RK4_SIGNATURE), "dop853": (dop853, DOP853_SIGNATURE)}
    source, signature = sources[name]
    kernel: Callable[..., Any] = njit(signature, **OPTIONS)(source.py_func)
    return kernel
