"""Derivatives of a chain's L = sum_ij A_ij cos(q_i - q_j) v_i v_j / 2 + sum_i B_i cos(q_i).

g, v (n,)   angles from the downward vertical and their rates;   out (2, n)  dL/dv and dL/dq
constants   A by rows (n n,), symmetric, and B (n,)
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit

ROWS = types.Array(types.float64, 2, "A", readonly=True)
NUMBERS = types.Array(types.float64, 1, "C", readonly=True)


@jit
def planar_chain(g, v, t, constants, out):
    """out <- sum_j A_ij cos(q_i - q_j) v_j,  -sum_j A_ij sin(q_i - q_j) v_i v_j - B_i sin(q_i)."""
    n = g.size
    seen = np.empty((2, n))
    for i in range(n):
        seen[0, i], seen[1, i] = np.cos(g[i]), np.sin(g[i])
    for i in range(n):
        along, across = 0.0, 0.0
        for j in range(n):
            pull = constants[n * i + j] * v[j]
            along += pull * (seen[0, i] * seen[0, j] + seen[1, i] * seen[1, j])
            across += pull * (seen[1, i] * seen[0, j] - seen[0, i] * seen[1, j])
        out[0, i] = along
        out[1, i] = -v[i] * across - constants[n * n + i] * seen[1, i]


@jit
def planar_chain_states(g, v, constants, value, at_rest, momenta):
    """At k states, g and v (k, n): value and at_rest (k,) <- L and L without velocities, momenta
    (k, n) <- dL/dv."""
    n = g.shape[1]
    seen = np.empty((2, n))
    for k in range(g.shape[0]):
        at_rest[k], value[k] = 0.0, 0.0
        for i in range(n):
            seen[0, i], seen[1, i] = np.cos(g[k, i]), np.sin(g[k, i])
            at_rest[k] += constants[n * n + i] * seen[0, i]
        for i in range(n):
            along = 0.0
            for j in range(n):
                turn = seen[0, i] * seen[0, j] + seen[1, i] * seen[1, j]
                along += constants[n * i + j] * v[k, j] * turn
            momenta[k, i] = along
            value[k] += 0.5 * v[k, i] * along
        value[k] += at_rest[k]


@cache
def compiled_planar_chain_states():
    """``planar_chain_states`` compiled or cached."""
    return compiled_for(
        planar_chain_states, types.void(ROWS, ROWS, NUMBERS, VECTOR, VECTOR, MATRIX)
    )
