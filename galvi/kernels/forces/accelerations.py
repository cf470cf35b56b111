"""Accelerations of any system at all stages: a = -M^-1 dV/dq, or those that a force law returns.

functions     (2,) addresses of a force of a kind in galvi.kernels.forces.force_kinds, and of its
              derivative
Q             (d, s)  configuration at the stages
t             (s,)    stage times
inverse_mass  (d, 1) diagonal, (d, d) full, or (0, 0) if the force law returns accelerations

Their derivatives, for Newton's method, are (d, w, s): row i holds da_i/dq for the w components in
the block of i.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.function_pointers import call_matrix, call_vector, call_void
from galvi.kernels.compile.jit import jit, jit_inline
from galvi.kernels.forces import force_kinds

BUILT_IN = force_kinds.BUILT_IN
TIMED_GRADIENT = force_kinds.TIMED_GRADIENT


@jit_inline
def accelerations(kind, functions, constants, inverse_mass, Q, t, out):
    """Fill out (d, s) with the accelerations."""
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
    """out[:, k] <- values (d,); NaN if a user's function returned another length."""
    fits = values.size == out.shape[0]
    for i in range(out.shape[0]):
        out[i, k] = values[i] if fits else np.nan


@jit_inline
def apply_inverse_mass(inverse_mass, gradients):
    """gradients (d, s) <- -M^-1 gradients; unchanged for an inverse mass (0, 0)."""
    if inverse_mass.shape[1] == 1:
        for i in range(gradients.shape[0]):
            for k in range(gradients.shape[1]):
                gradients[i, k] *= -inverse_mass[i, 0]
    elif inverse_mass.shape[1] > 1:
        apply_full(inverse_mass, gradients)


@jit
def apply_full(inverse_mass, gradients):
    """`apply_inverse_mass` for a full inverse mass (d, d)."""
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


GRADIENT = force_kinds.GRADIENT
DIFFERENCE_STEP = 2.0**-20


@jit
def jacobians(kind, functions, has_hessian, constants, inverse_mass, Q, t, out):
    """Fill out (d, w, s), from the Hessian if there is one, else by central differences.

    Differences move one component of a whole configuration, so that they need a single block, w =
    d. Returns the number of force evaluations at single configurations, 0 with a Hessian.
    """
    d, width, stages = out.shape
    if not has_hessian:
        step = difference_step(Q)
        ahead, behind = np.empty((d, stages)), np.empty((d, stages))
        for j in range(width):
            moved_Q = shifted(Q, j, step)
            accelerations(kind, functions, constants, inverse_mass, moved_Q, t, ahead)
            moved_Q = shifted(Q, j, -step)
            accelerations(kind, functions, constants, inverse_mass, moved_Q, t, behind)
            for i in range(d):
                for k in range(stages):
                    out[i, j, k] = (ahead[i, k] - behind[i, k]) / (2.0 * step)
        return 2 * width * stages
    if kind == GRADIENT:
        for k in range(stages):
            fill_matrix(call_matrix(functions[1], stage(Q, k)), k, out)
    elif kind == TIMED_GRADIENT:
        for k in range(stages):
            fill_matrix(call_matrix(functions[1], stage(Q, k), t[k]), k, out)
    else:
        call_void(functions[1], Q, t, constants, out)
    apply_inverse_mass_to_rows(inverse_mass, out)
    return 0


@jit
def difference_step(Q):
    """2^-20 times the largest |Q|, or 2^-20 if all are 0."""
    size = 0.0
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            size = max(size, abs(Q[i, k]))
    return DIFFERENCE_STEP * size if size > 0.0 else DIFFERENCE_STEP


@jit
def shifted(Q, j, step):
    """Q with component j moved by step."""
    moved = np.empty(Q.shape)
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            moved[i, k] = Q[i, k] + step if i == j else Q[i, k]
    return moved


@jit
def fill_matrix(values, k, out):
    """out[:, :, k] <- values (d, d); NaN if a user's function returned another shape."""
    d = out.shape[0]
    fits = values.shape[0] == d and values.shape[1] == d
    for i in range(d):
        for j in range(d):
            out[i, j, k] = values[i, j] if fits else np.nan


@jit
def apply_inverse_mass_to_rows(inverse_mass, hessians):
    """hessians (d, w, s) <- -M^-1 hessians; unchanged for an inverse mass (0, 0), else w = d."""
    d, width, stages = hessians.shape
    if inverse_mass.shape[1] == 1:
        for i in range(d):
            for j in range(width):
                for k in range(stages):
                    hessians[i, j, k] *= -inverse_mass[i, 0]
    elif inverse_mass.shape[1] > 1:
        column = np.empty(d)
        for k in range(stages):
            for j in range(width):
                for i in range(d):
                    column[i] = hessians[i, j, k]
                for i in range(d):
                    total = 0.0
                    for l in range(d):
                        total -= inverse_mass[i, l] * column[l]
                    hessians[i, j, k] = total
