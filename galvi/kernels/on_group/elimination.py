"""Linear equations by Gaussian elimination with partial pivoting, without allocation."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_noalloc


@jit_noalloc
def factor(matrix, pivots):
    """matrix <- its LU factors with partial pivoting, in place; returns whether it is regular."""
    n = matrix.shape[0]
    for k in range(n):
        best, row = 0.0, k
        for i in range(k, n):
            if abs(matrix[i, k]) > best:
                best, row = abs(matrix[i, k]), i
        if not 0.0 < best < np.inf:
            return False
        pivots[k] = row
        if row != k:
            for j in range(n):
                matrix[k, j], matrix[row, j] = matrix[row, j], matrix[k, j]
        for i in range(k + 1, n):
            ratio = matrix[i, k] / matrix[k, k]
            matrix[i, k] = ratio
            if ratio != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= ratio * matrix[k, j]
    return True


@jit_noalloc
def substitute(matrix, pivots, rhs):
    """rhs <- A^-1 rhs from the factors of A."""
    n = matrix.shape[0]
    for k in range(n):
        rhs[k], rhs[pivots[k]] = rhs[pivots[k]], rhs[k]
    for k in range(n):
        for i in range(k + 1, n):
            rhs[i] -= matrix[i, k] * rhs[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            rhs[k] -= matrix[k, j] * rhs[j]
        rhs[k] /= matrix[k, k]
