"""dV/dq of the built-in potentials, and from them dV/dq and d2V/dq2 at all s stages at once.

q (d,), c constants; the functions fill out (d,), for numbers, complex or not, arrays and lanes

Q (d, s) configurations; a gradient fills out (d, s), a Hessian out (d, d, s)
"""

from __future__ import annotations

from functools import cache

import numpy as np

from galvi.kernels.compile.jit import jit, jit_noalloc, renamed
from galvi.kernels.constants import COMPLEX_STEP
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.elementary import over_cube, sin


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


@cache
def over_stages(slopes):
    """The gradient and the Hessian of a potential at all stages, from its dV/dq.

    The Hessian is that of complex steps, which lose no digits.
    """

    def gradient(Q, t, constants, out):
        for k in range(Q.shape[1]):
            slopes(Q[:, k], constants, out[:, k])

    def hessian(Q, t, constants, out):
        d = Q.shape[0]
        q, column = np.empty(d, np.complex128), np.empty(d, np.complex128)
        for k in range(Q.shape[1]):
            for i in range(d):
                q[i] = Q[i, k]
            for j in range(d):
                q[j] = complex(Q[j, k], COMPLEX_STEP)
                slopes(q, constants, column)
                q[j] = Q[j, k]
                for i in range(d):
                    out[i, j, k] = column[i].imag / COMPLEX_STEP

    names = f"{slopes.__name__}_gradient", f"{slopes.__name__}_hessian"
    return jit_noalloc(renamed(gradient, names[0])), jit(renamed(hessian, names[1]))
