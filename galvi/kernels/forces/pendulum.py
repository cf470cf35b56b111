"""dV/dq of the pendulum V = -weight sum cos(q_i).   constants [weight],  Q (d, s)."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit


@jit
def gradient(Q, t, constants, out):
    """weight sin(q_i) at all stages, (d, s)."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = constants[0] * np.sin(Q[i, k])


@jit
def hessian(Q, t, constants, out):
    """weight cos(q_i) on the diagonal at all stages, (d, d, s)."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            for j in range(Q.shape[0]):
                out[i, j, k] = 0.0
            out[i, i, k] = constants[0] * np.cos(Q[i, k])
