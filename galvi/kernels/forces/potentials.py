"""dV/dq and d2V/dq2 of the built-in potentials, at one configuration and at all s stages.

At q (d,) with constants c, dV/dq fills out (d,), for numbers, complex or not, arrays and lanes;
d2V/dq2 sets the entries of out (d, d) that are not 0. At Q (d, s), a gradient fills out (d, s), a
Hessian out (d, d, s).
"""

from __future__ import annotations

from functools import cache

from galvi.kernels.compile.jit import jit_noalloc, set_name
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.elementary import over_cube, sin, sine_cosine


@generic
def central_force(q, c, out):
    """mu q / |q|^3, of V = -mu / |q|; constants [mu]."""
    square = q[0] * q[0]
    for i in range(1, len(q)):
        square = square + q[i] * q[i]
    pull = over_cube(c[0], square)
    for i in range(len(q)):
        out[i] = pull * q[i]


@generic
def linear_spring(q, c, out):
    """k q, of V = k |q|^2 / 2; constants [k]."""
    for i in range(len(q)):
        out[i] = c[0] * q[i]


@generic
def pendulum(q, c, out):
    """weight sin(q_i), of V = -weight sum cos(q_i); constants [weight]."""
    for i in range(len(q)):
        out[i] = c[0] * sin(q[i])


@generic
def spring_chain(q, c, out):
    """dV/dq of V = sum_i r_i^2/2 + alpha r_i^3/3 + beta r_i^4/4, a chain with fixed ends.

    r_i = q_i - q_{i-1}, i = 1 .. d+1, q_0 = q_{d+1} = 0; constants [alpha, beta]
    """
    last = len(q) - 1
    force = spring(q[0], c)
    for i in range(last):
        following = spring(q[i + 1] - q[i], c)
        out[i] = force - following
        force = following
    out[last] = force - spring(-q[last], c)


@generic
def spring(r, c):
    """The force r (1 + r (alpha + r beta)) of a spring."""
    return r * (1.0 + r * (c[0] + r * c[1]))


@generic
def uniform_field(q, c, out):
    """-f, of V = -f . q; constants f (d,)."""
    for i in range(len(q)):
        out[i] = 0.0 - c[i]  # 0 where c is, not -0


@generic
def central_force_hessian(q, c, out):
    """mu (I - 3 q q^T / |q|^2) / |q|^3."""
    square = q[0] * q[0]
    for i in range(1, len(q)):
        square = square + q[i] * q[i]
    pull = over_cube(c[0], square)
    for i in range(len(q)):
        for j in range(len(q)):
            out[i, j] = -3.0 * pull * q[i] * q[j] / square
        out[i, i] += pull


@generic
def linear_spring_hessian(q, c, out):
    """k I."""
    for i in range(len(q)):
        out[i, i] = c[0]


@generic
def pendulum_hessian(q, c, out):
    """weight cos(q_i) on the diagonal."""
    for i in range(len(q)):
        out[i, i] = c[0] * sine_cosine(q[i])[1]


@generic
def spring_chain_hessian(q, c, out):
    """Tridiagonal stiffness."""
    last = len(q) - 1
    stiffness = spring_stiffness(q[0], c)
    for i in range(last):
        following = spring_stiffness(q[i + 1] - q[i], c)
        out[i, i] = stiffness + following
        out[i, i + 1], out[i + 1, i] = -following, -following
        stiffness = following
    out[last, last] = stiffness + spring_stiffness(-q[last], c)


@generic
def spring_stiffness(r, c):
    """1 + r (2 alpha + 3 r beta) of a spring."""
    return 1.0 + r * (2.0 * c[0] + 3.0 * r * c[1])


@generic
def uniform_field_hessian(q, c, out):
    """0: no entry of out is set."""


@cache
def over_stages(slopes, second_derivatives):
    """The compiled gradient and Hessian of a potential at all stages, from dV/dq and d2V/dq2."""

    def gradient(Q, t, constants, out):
        for k in range(Q.shape[1]):
            slopes(Q[:, k], constants, out[:, k])

    def hessian(Q, t, constants, out):
        out[:, :, :] = 0.0
        for k in range(Q.shape[1]):
            second_derivatives(Q[:, k], constants, out[:, :, k])

    names = f"{slopes.__name__}_gradient", f"{slopes.__name__}_hessian"
    return jit_noalloc(set_name(gradient, names[0])), jit_noalloc(set_name(hessian, names[1]))
