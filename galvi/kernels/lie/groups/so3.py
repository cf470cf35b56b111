"""Rotations of space: matrices (3, 3), and three angular velocities of the body."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_inline
from galvi.kernels.lie import rotations
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.rotations import rotation, times, transpose


@jit_inline
def relative_coordinates(chart, g, k, row, xi):
    """xi <- coordinates of the rotation from g to k, in matrices with rows of length ``row``."""
    start, end = columns(g, row), columns(k, row)
    turn = times(end, start[0]), times(end, start[1]), times(end, start[2])
    rotations.coordinates(chart, turn, xi)


@generic
def columns(g, row):
    """Three columns of a matrix with rows of length ``row``."""
    return (
        (g[0], g[row], g[2 * row]),
        (g[1], g[row + 1], g[2 * row + 1]),
        (g[2], g[row + 2], g[2 * row + 2]),
    )


@jit
def restore_rotation(g, row):
    """One Newton step to orthogonality, in a matrix with rows of length ``row``."""
    R, out = np.empty((3, 3)), np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            R[i, j] = g[row * i + j]
    rotations.orthonormal(R, out)
    for i in range(3):
        for j in range(3):
            g[row * i + j] = out[i, j]


@jit_inline
def turn_derivatives(g, slope, row, out):
    """out (3,) <- the derivatives along rotations of g, in a matrix with rows of length ``row``."""
    for a in range(3):
        j, k = (a + 1) % 3, (a + 2) % 3
        out[a] = 0.0
        for i in range(3):
            out[a] += g[row * i + k] * slope[row * i + j] - g[row * i + j] * slope[row * i + k]


@jit_inline
def place(chart, g, xi, out):
    """out <- g Phi(xi)."""
    columns = transpose(rotation(chart, xi))
    for i in range(3):
        row = g[3 * i], g[3 * i + 1], g[3 * i + 2]
        out[3 * i], out[3 * i + 1], out[3 * i + 2] = times(columns, row)


@jit_inline
def tangent(chart, xi, eta, T, G):
    """T and G, (3, 3)."""
    rotations.tangent(chart, xi, eta, T, G)


@jit_inline
def coordinates(chart, g, k, xi):
    """xi <- the coordinates of g^T k."""
    relative_coordinates(chart, g, k, 3, xi)


@jit_inline
def restore(g):
    """One Newton step to orthogonality."""
    restore_rotation(g, 3)


@jit_inline
def coadjoint_inverse(chart, xi, mu, out):
    """out <- R mu."""
    out[0], out[1], out[2] = times(rotation(chart, xi), mu)


@jit_inline
def coadjoint(chart, xi, mu, out):
    """out <- R^T mu."""
    out[0], out[1], out[2] = times(transpose(rotation(chart, xi)), mu)


@jit_inline
def left_derivative(g, slope, out):
    """out <- the derivatives along rotations."""
    turn_derivatives(g, slope, 3, out)


@jit_inline
def position_scale(g):
    """0: a rotation has no position."""
    return 0.0


@jit_inline
def with_rotation(chart, xi, w, out):
    """out <- w."""
    for i in range(w.size):
        out[i] = w[i]
