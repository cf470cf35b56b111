"""Derivatives of a chain's L = sum_ij A_ij cos(q_i - q_j) v_i v_j / 2 + sum_i B_i cos(q_i).

g, v (n,)   angles from the downward vertical and their rates;   out (2, n)  dL/dv and dL/dq
constants   A by rows (n n,), symmetric, and B (n,)
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit


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
