"""dV/dq of a chain with fixed ends, V = sum_i r_i^2/2 + alpha r_i^3/3 + beta r_i^4/4.

r_i = q_i - q_{i-1}, i = 1 .. d+1, q_0 = q_{d+1} = 0.   constants [alpha, beta],  Q (d, s)
"""

from __future__ import annotations

from galvi.kernels.compile.jit import jit


@jit
def gradient(Q, t, constants, out):
    """dV/dq at all stages, (d, s)."""
    alpha, beta = constants
    d = Q.shape[0]
    out[:, :] = 0.0
    for k in range(Q.shape[1]):
        for i in range(d + 1):
            r = (Q[i, k] if i < d else 0.0) - (Q[i - 1, k] if i > 0 else 0.0)
            force = r * (1.0 + r * (alpha + r * beta))
            if i < d:
                out[i, k] += force
            if i > 0:
                out[i - 1, k] -= force


@jit
def hessian(Q, t, constants, out):
    """Tridiagonal stiffness, (d, d, s)."""
    alpha, beta = constants
    d = Q.shape[0]
    out[:, :, :] = 0.0
    for k in range(Q.shape[1]):
        for i in range(d + 1):
            r = (Q[i, k] if i < d else 0.0) - (Q[i - 1, k] if i > 0 else 0.0)
            stiffness = 1.0 + r * (2.0 * alpha + 3.0 * r * beta)
            if i < d:
                out[i, i, k] += stiffness
            if i > 0:
                out[i - 1, i - 1, k] += stiffness
            if 0 < i < d:
                out[i, i - 1, k] -= stiffness
                out[i - 1, i, k] -= stiffness
