"""dV/dq and d2V/dq2 of the built-in potentials, at all s stages at once.

Q (d, s) configurations; a gradient fills out (d, s), a Hessian out (d, d, s)
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_inline


@jit_inline
def square_and_pull(Q, k, mu):
    """|q|^2 and mu / |q|^3 at a stage."""
    square = 0.0
    for i in range(Q.shape[0]):
        square += Q[i, k] * Q[i, k]
    return square, mu / (square * np.sqrt(square))


@jit
def central_gradient(Q, t, constants, out):
    """mu q / |q|^3, of V = -mu / |q|; constants [mu]."""
    for k in range(Q.shape[1]):
        _, pull = square_and_pull(Q, k, constants[0])
        for i in range(Q.shape[0]):
            out[i, k] = pull * Q[i, k]


@jit
def central_hessian(Q, t, constants, out):
    """mu (I - 3 q q^T / |q|^2) / |q|^3."""
    for k in range(Q.shape[1]):
        square, pull = square_and_pull(Q, k, constants[0])
        for i in range(Q.shape[0]):
            for j in range(Q.shape[0]):
                out[i, j, k] = -3.0 * pull * Q[i, k] * Q[j, k] / square
            out[i, i, k] += pull


@jit
def spring_gradient(Q, t, constants, out):
    """k q, of V = k |q|^2 / 2; constants [k]."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = constants[0] * Q[i, k]


@jit
def spring_hessian(Q, t, constants, out):
    """k I."""
    out[:, :, :] = 0.0
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, i, k] = constants[0]


@jit
def cosine_gradient(Q, t, constants, out):
    """weight sin(q_i), of V = -weight sum cos(q_i); constants [weight]."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = constants[0] * np.sin(Q[i, k])


@jit
def cosine_hessian(Q, t, constants, out):
    """weight cos(q_i) on the diagonal."""
    out[:, :, :] = 0.0
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, i, k] = constants[0] * np.cos(Q[i, k])


@jit
def chain_gradient(Q, t, constants, out):
    """dV/dq of V = sum_i r_i^2/2 + alpha r_i^3/3 + beta r_i^4/4, a chain with fixed ends.

    r_i = q_i - q_{i-1}, i = 1 .. d+1, q_0 = q_{d+1} = 0; constants [alpha, beta]
    """
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
def chain_hessian(Q, t, constants, out):
    """Tridiagonal stiffness."""
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


@jit
def uniform_gradient(Q, t, constants, out):
    """-f, of V = -f . q; constants f (d,)."""
    for i in range(Q.shape[0]):
        for k in range(Q.shape[1]):
            out[i, k] = -constants[i]


@jit
def uniform_hessian(Q, t, constants, out):
    """0."""
    out[:, :, :] = 0.0
