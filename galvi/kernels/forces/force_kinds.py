"""Kinds of force that kernels evaluate, and the types of their functions.

Q    (d, s)  configuration at the s stages, one row for each component
t    (s,)    stage times

A system has two functions, its force and, optionally, the derivative of the force:

BUILT_IN        a law for all stages at once, (Q, t, constants, out (d, s)), and its derivative,
                (Q, t, constants, out (d, w, s)), w components of the block of each row
GRADIENT        a user's dV/dq (q (d,)) -> (d,) of one configuration, and d2V/dq2 (q) -> (d, d)
TIMED_GRADIENT  the same functions of (q, t)
"""

from __future__ import annotations

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, REAL, TENSOR3, VECTOR

BUILT_IN = 0
GRADIENT = 1
TIMED_GRADIENT = 2

SIGNATURES = {
    BUILT_IN: (
        types.void(MATRIX, VECTOR, VECTOR, MATRIX),
        types.void(MATRIX, VECTOR, VECTOR, TENSOR3),
    ),
    GRADIENT: (VECTOR(VECTOR), MATRIX(VECTOR)),
    TIMED_GRADIENT: (VECTOR(VECTOR, REAL), MATRIX(VECTOR, REAL)),
}


def no_constants():
    """The constants (0,) of a force law that has none."""
    return np.zeros(0)
