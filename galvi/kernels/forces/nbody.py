"""Newtonian gravity of point masses, and their potential energy.

a_i = sum over j != i of Gm_j (q_j - q_i) / |q_j - q_i|^3

constants  [dimension, Gm_1, ..., Gm_N], Gm = 0 for bodies that do not pull; what follows is not
           read here
Q          (N * dimension, s), body by body
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import VECTOR, compiled_for, jit, jit_noalloc


@jit
def accelerations(Q, t, constants, out):
    """Accelerations of all bodies at all stages, (N * dimension, s)."""
    dimension = int(constants[0])
    bodies = Q.shape[0] // dimension
    stages = Q.shape[1]
    pull = np.empty(stages)
    out[:, :] = 0.0
    for i in range(bodies):
        mass_i = constants[1 + i]
        for j in range(i + 1, bodies):
            mass_j = constants[1 + j]
            if mass_i + mass_j == 0.0:
                continue
            pull[:] = 0.0
            for x in range(dimension):
                for k in range(stages):
                    gap = Q[j * dimension + x, k] - Q[i * dimension + x, k]
                    pull[k] += gap * gap
            for k in range(stages):
                pull[k] = 1.0 / (pull[k] * np.sqrt(pull[k]))
            for x in range(dimension):
                row_i = i * dimension + x
                row_j = j * dimension + x
                for k in range(stages):
                    gap = (Q[row_j, k] - Q[row_i, k]) * pull[k]
                    out[row_i, k] += mass_j * gap
                    out[row_j, k] -= mass_i * gap


@jit
def pull_slope(Q, i, j, k, dimension, mass, slope):
    """slope <- mass (3 g g^T / |g|^2 - I) / |g|^3, g from body i to body j at stage k.

    The derivative of the attraction of i by j with respect to q_i, (dimension, dimension).
    """
    square = 0.0
    for x in range(dimension):
        gap = Q[j * dimension + x, k] - Q[i * dimension + x, k]
        square += gap * gap
    pull = mass / (square * np.sqrt(square))
    for x in range(dimension):
        along = 3.0 * (Q[j * dimension + x, k] - Q[i * dimension + x, k]) / square
        for y in range(dimension):
            slope[x, y] = pull * along * (Q[j * dimension + y, k] - Q[i * dimension + y, k])
        slope[x, x] -= pull


@jit
def fill_jacobians(Q, constants, coupled, out):
    """out <- derivatives of each body's acceleration by its own position or, if ``coupled``, by all
    positions."""
    dimension = int(constants[0])
    bodies = Q.shape[0] // dimension
    out[:, :, :] = 0.0
    slope = np.empty((dimension, dimension))
    for k in range(Q.shape[1]):
        for i in range(bodies):
            for j in range(bodies):
                if i != j and constants[1 + j] > 0.0:
                    pull_slope(Q, i, j, k, dimension, constants[1 + j], slope)
                    for x in range(dimension):
                        row, first = i * dimension + x, i * dimension if coupled else 0
                        for y in range(dimension):
                            out[row, first + y, k] += slope[x, y]
                            if coupled:
                                out[row, j * dimension + y, k] -= slope[x, y]


@jit
def own_jacobians(Q, t, constants, out):
    """Derivative of each body's acceleration by its own position, (N * dimension, dimension, s).

    The coupling to the positions of other bodies is omitted: it is smaller by the mass ratio for
    all but the heaviest body.
    """
    fill_jacobians(Q, constants, False, out)


@jit
def all_jacobians(Q, t, constants, out):
    """Derivative of every body's acceleration by every position, (d, d, s), d = N * dimension.

    For few bodies of similar mass, where the coupling that own_jacobians omits is not small.
    """
    fill_jacobians(Q, constants, True, out)


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
    """The compiled ``pair_potential``."""
    return compiled_for(pair_potential, SIGNATURE, jit_noalloc)
