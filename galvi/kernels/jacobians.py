"""Derivatives of the accelerations of any system at all stages, for Newton's method.

Q    (d, s)     configuration at the stages
out  (d, w, s)  row i holds d a_i / d q of the w components in the block of i
"""

from __future__ import annotations

import numpy as np

from galvi.kernels import laws
from galvi.kernels.accelerations import accelerations
from galvi.kernels.jit import jit

GRADIENT = laws.GRADIENT
TIMED_GRADIENT = laws.TIMED_GRADIENT
STEP = 2.0**-20


@jit
def jacobians(functions, has_hessian, constants, inverse_mass, Q, t, out):
    """Fill out; from the Hessian where there is one, else by central differences of the force.

    Returns the number of single-configuration force evaluations it took (0 with a Hessian).
    """
    kind, law, law_jacobian, gradient, timed_gradient, hessian, timed_hessian = functions
    d, width, stages = out.shape
    if not has_hessian:
        ahead = np.empty((d, stages))
        behind = np.empty((d, stages))
        size = np.abs(Q).max()
        step = STEP * size if size > 0.0 else STEP
        moved = Q.copy()
        for j in range(width):
            for i in range(j, d, width):
                moved[i] = Q[i] + step
            accelerations(
                kind, law, gradient, timed_gradient, constants, inverse_mass, moved, t, ahead
            )
            for i in range(j, d, width):
                moved[i] = Q[i] - step
            accelerations(
                kind, law, gradient, timed_gradient, constants, inverse_mass, moved, t, behind
            )
            for i in range(j, d, width):
                moved[i] = Q[i]
            out[:, j, :] = (ahead - behind) / (2.0 * step)
        return 2 * width * stages
    if kind == GRADIENT:
        for k in range(stages):
            out[:, :, k] = hessian(Q[:, k].copy())
    elif kind == TIMED_GRADIENT:
        for k in range(stages):
            out[:, :, k] = timed_hessian(Q[:, k].copy(), t[k])
    else:
        law_jacobian(Q, t, constants, out)
    apply_inverse_mass_to_rows(inverse_mass, out)
    return 0


@jit
def apply_inverse_mass_to_rows(inverse_mass, hessians):
    """hessians <- -M^-1 hessians, in place, (d, w, s); w = d unless the law is the acceleration."""
    d, width, stages = hessians.shape
    if inverse_mass.shape[1] == 1:
        for i in range(d):
            hessians[i] *= -inverse_mass[i, 0]
    elif inverse_mass.shape[1] > 1:
        for k in range(stages):
            for j in range(width):
                column = hessians[:, j, k].copy()
                for i in range(d):
                    total = 0.0
                    for l in range(d):
                        total -= inverse_mass[i, l] * column[l]
                    hessians[i, j, k] = total
