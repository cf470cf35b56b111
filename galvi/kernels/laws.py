"""The kinds of function a kernel can call for a force, their compiled types, and stand-ins.

A kernel takes functions of six types. A system fills the ones it has; a stand-in of the right type,
never called, fills the others, so that one compiled kernel, cached on disk, serves every system.

Q    (d, s)  configuration at the s stages, one row for each component
t    (s,)    stage times
"""

from __future__ import annotations

import numpy as np
from numba import types

from galvi.kernels.jit import jit

BUILT_IN = 0
GRADIENT = 1
TIMED_GRADIENT = 2

VECTOR = types.float64[::1]
MATRIX = types.float64[:, ::1]
BLOCKS = types.float64[:, :, ::1]

LAW = types.FunctionType(types.void(MATRIX, VECTOR, VECTOR, MATRIX))
LAW_JACOBIAN = types.FunctionType(types.void(MATRIX, VECTOR, VECTOR, BLOCKS))
GRADIENT_TYPE = types.FunctionType(VECTOR(VECTOR))
TIMED_GRADIENT_TYPE = types.FunctionType(VECTOR(VECTOR, types.float64))
HESSIAN_TYPE = types.FunctionType(MATRIX(VECTOR))
TIMED_HESSIAN_TYPE = types.FunctionType(MATRIX(VECTOR, types.float64))


def no_constants():
    """Stand-in for the constants of a law."""
    return np.zeros(0)


@jit
def no_law(Q, t, constants, out):
    """Stand-in for a law."""


@jit
def no_law_jacobian(Q, t, constants, out):
    """Stand-in for the derivative of a law."""


@jit
def no_gradient(q):
    """Stand-in for a user's gradient(q)."""
    return q.copy()


@jit
def no_timed_gradient(q, t):
    """Stand-in for a user's gradient(q, t)."""
    return q.copy()


@jit
def no_hessian(q):
    """Stand-in for a user's hessian(q)."""
    return np.zeros((q.size, q.size))


@jit
def no_timed_hessian(q, t):
    """Stand-in for a user's hessian(q, t)."""
    return np.zeros((q.size, q.size))
