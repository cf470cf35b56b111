"""The potential energy of point masses."""

from __future__ import annotations

import math
from functools import cache

from numba import types

from galvi.kernels.compile.jit import VECTOR, compiled_for, jit_noalloc

SIGNATURE = types.void(
    *(types.Array(types.float64, n, "C", readonly=True) for n in (3, 1)), types.float64, VECTOR
)


@jit_noalloc
def pair_potential(q, masses, G, out):
    """out (n,) <- -sum over pairs G m_i m_j / |q_i - q_j| at q (n, bodies, dimension)."""
    for k in range(out.size):
        total = 0.0
        for i in range(masses.size):
            pull = 0.0
            for j in range(i):
                if masses[i] > 0.0 and masses[j] > 0.0:
                    square = 0.0
                    for x in range(q.shape[2]):
                        gap = q[k, i, x] - q[k, j, x]
                        square += gap * gap
                    pull += masses[j] / math.sqrt(square)
            total -= G * masses[i] * pull
        out[k] = total


@cache
def compiled_pair_potential():
    """``pair_potential`` compiled or cached."""
    return compiled_for(pair_potential, SIGNATURE, jit_noalloc)
