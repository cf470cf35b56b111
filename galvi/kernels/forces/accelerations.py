"""Accelerations of any system at all stages: a = -M^-1 dV/dq, or given directly by a law.

functions     (2,) force of a kind in galvi.kernels.forces.force_kinds, and its derivative
Q             (d, s)  configuration at the stages
t             (s,)    stage times
inverse_mass  (d, 1) diagonal, (d, d) full, or (0, 0) when the law gives accelerations
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.function_pointers import call_vector, call_void
from galvi.kernels.compile.jit import jit, jit_inline
from galvi.kernels.forces import force_kinds

BUILT_IN = force_kinds.BUILT_IN
TIMED_GRADIENT = force_kinds.TIMED_GRADIENT


@jit_inline
def accelerations(kind, functions, constants, inverse_mass, Q, t, out):
    """Fill out (d, s) with the accelerations; all forces are evaluated here."""
    if kind == BUILT_IN:
        call_void(functions[0], Q, t, constants, out)
    else:
        gradients(kind, functions, Q, t, out)
    apply_inverse_mass(inverse_mass, out)


@jit
def gradients(kind, functions, Q, t, out):
    """Fill out (d, s) with a user's gradients."""
    for k in range(Q.shape[1]):
        if kind == TIMED_GRADIENT:
            fill_stage(call_vector(functions[0], stage(Q, k), t[k]), k, out)
        else:
            fill_stage(call_vector(functions[0], stage(Q, k)), k, out)


@jit
def stage(Q, k):
    """A copy of the configuration at stage k, (d,)."""
    q = np.empty(Q.shape[0])
    for i in range(Q.shape[0]):
        q[i] = Q[i, k]
    return q


@jit
def fill_stage(values, k, out):
    """out[:, k] <- values, (d,); NaN when a user's function returned a wrong length."""
    fits = values.size == out.shape[0]
    for i in range(out.shape[0]):
        out[i, k] = values[i] if fits else np.nan


@jit_inline
def apply_inverse_mass(inverse_mass, gradients):
    """gradients <- -M^-1 gradients, in place, (d, s)."""
    if inverse_mass.shape[1] == 1:
        for i in range(gradients.shape[0]):
            for k in range(gradients.shape[1]):
                gradients[i, k] *= -inverse_mass[i, 0]
    elif inverse_mass.shape[1] > 1:
        apply_full(inverse_mass, gradients)


@jit
def apply_full(inverse_mass, gradients):
    """As ``apply_inverse_mass``, for a full inverse mass (d, d)."""
    d, stages = gradients.shape
    column = np.empty(d)
    for k in range(stages):
        for i in range(d):
            column[i] = gradients[i, k]
        for i in range(d):
            total = 0.0
            for j in range(d):
                total -= inverse_mass[i, j] * column[j]
            gradients[i, k] = total
