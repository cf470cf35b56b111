"""Bounds of coordinates on the curves of steps."""

from functools import cache

from numba import types

from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit


@jit
def curve_bounds(bases, parts, psi_centre, psi_radius, low, high):
    """low, high (d, n) <- bounds of bases[k] + parts[k] @ psi on each of n steps.

    Parameters
    ----------
    bases : array, shape (n, d) or (1, d)
        (1, d) for the same base in all steps
    parts : array, shape (n, d, m)
    psi_centre, psi_radius : array, shape (m,)
        |psi_l - psi_centre_l| is at most psi_radius_l
    """
    n, d, m = parts.shape
    for k in range(n):
        row = min(k, bases.shape[0] - 1)
        for i in range(d):
            centre, radius = bases[row, i], 0.0
            for l in range(m):
                centre += parts[k, i, l] * psi_centre[l]
                radius += abs(parts[k, i, l]) * psi_radius[l]
            low[i, k], high[i, k] = centre - radius, centre + radius


@cache
def compiled_curve_bounds():
    """The compiled ``curve_bounds``."""
    bases, parts = (types.Array(types.float64, k, "C", readonly=True) for k in (2, 3))
    return compiled_for(curve_bounds, types.void(bases, parts, VECTOR, VECTOR, MATRIX, MATRIX))
