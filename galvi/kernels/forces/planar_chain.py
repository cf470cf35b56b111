"""Derivatives of a chain's L = sum_ij A_ij cos(q_i - q_j) v_i v_j / 2 + sum_i B_i cos(q_i).

g, v (n,)   angles from the downward vertical and their rates;   out (2, n)  dL/dv and dL/dq
constants   A by rows (n n,), symmetric, and B (n,)
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.elementary import sine_cosine

ROWS = types.Array(types.float64, 2, "A", readonly=True)
NUMBERS = types.Array(types.float64, 1, "C", readonly=True)


@generic
def planar_chain_slopes(q, v, c, sines, cosines, momenta, forces, mass):
    """momenta (n,) <- sum_j A_ij cos(q_i - q_j) v_j; forces (n,) <- -sum_j A_ij sin(q_i - q_j) v_i
    v_j - B_i sin(q_i); mass <- the rows of A_ij cos(q_i - q_j) up to the diagonal; sines and
    cosines (n,) <- those of q_i."""
    n = len(q)
    for i in range(n):
        sines[i], cosines[i] = sine_cosine(q[i])
        mass[i][i] = c[n * i + i]
        momenta[i], forces[i] = c[n * i + i] * v[i], 0.0
        for j in range(i):
            A = c[n * i + j]
            cosine_term = A * (cosines[i] * cosines[j] + sines[i] * sines[j])
            sine_term = A * (sines[i] * cosines[j] - cosines[i] * sines[j])
            momenta[i], momenta[j] = (
                momenta[i] + cosine_term * v[j],
                momenta[j] + cosine_term * v[i],
            )
            forces[i], forces[j] = forces[i] + sine_term * v[j], forces[j] - sine_term * v[i]
            mass[i][j] = cosine_term
    for i in range(n):
        forces[i] = -(v[i] * forces[i]) - c[n * n + i] * sines[i]


@jit
def planar_chain(g, v, t, constants, out):
    """out <- dL/dv and dL/dq."""
    n = g.size
    work = np.empty((n + 2, n))
    planar_chain_slopes(g, v, constants, work[n], work[n + 1], out[0], out[1], work)


@jit
def planar_chain_states(g, v, constants, value, at_rest, momenta):
    """At k states, g and v (k, n): value and at_rest (k,) <- L and L without velocities, momenta
    (k, n) <- dL/dv."""
    n = g.shape[1]
    work = np.empty((n + 3, n))
    sines, cosines, forces = work[n], work[n + 1], work[n + 2]
    for k in range(g.shape[0]):
        planar_chain_slopes(g[k], v[k], constants, sines, cosines, momenta[k], forces, work)
        at_rest[k], value[k] = 0.0, 0.0
        for i in range(n):
            at_rest[k] += constants[n * n + i] * cosines[i]
            value[k] += 0.5 * v[k, i] * momenta[k, i]
        value[k] += at_rest[k]


@cache
def compiled_planar_chain_states():
    """The compiled ``planar_chain_states``."""
    return compiled_for(
        planar_chain_states, types.void(ROWS, ROWS, NUMBERS, VECTOR, VECTOR, MATRIX)
    )
