"""dV/dq of V = -f . q.   constants f (d,),  Q (d, s)."""

from __future__ import annotations

from galvi.kernels.compile.jit import jit


@jit
def gradient(Q, t, constants, out):
    """-f at all stages, (d, s)."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = -constants[i]


@jit
def hessian(Q, t, constants, out):
    """0 at all stages, (d, d, s)."""
    out[:, :, :] = 0.0
