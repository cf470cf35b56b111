"""dV/dq of the central potential V = -mu / |q|.   constants [mu],  Q (d, s)."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit


@jit
def gradient(Q, t, constants, out):
    """mu q / |q|^3 at all stages, (d, s)."""
    for k in range(Q.shape[1]):
        square = 0.0
        for i in range(Q.shape[0]):
            square += Q[i, k] * Q[i, k]
        pull = constants[0] / (square * np.sqrt(square))
        for i in range(Q.shape[0]):
            out[i, k] = pull * Q[i, k]


@jit
def hessian(Q, t, constants, out):
    """mu (I - 3 q q^T / |q|^2) / |q|^3 at all stages, (d, d, s)."""
    for k in range(Q.shape[1]):
        square = 0.0
        for i in range(Q.shape[0]):
            square += Q[i, k] * Q[i, k]
        pull = constants[0] / (square * np.sqrt(square))
        for i in range(Q.shape[0]):
            for j in range(Q.shape[0]):
                out[i, j, k] = -3.0 * pull * Q[i, k] * Q[j, k] / square
            out[i, i, k] += pull
