"""dV/dq of the spring potential V = k |q|^2 / 2.   constants [k],  Q (d, s)."""

from __future__ import annotations

from galvi.kernels.compile.jit import jit


@jit
def gradient(Q, t, constants, out):
    """k q at all stages, (d, s)."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = constants[0] * Q[i, k]


@jit
def hessian(Q, t, constants, out):
    """k I at all stages, (d, d, s)."""
    out[:, :, :] = 0.0
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, i, k] = constants[0]
