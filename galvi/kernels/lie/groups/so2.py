"""Rotations of the plane: matrices (2, 2), and one angular velocity."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.lie.chart_functions import angle_of, angle_slopes, coordinate_of


@jit_inline
def turn(chart, g, x, row, out):
    """out <- g rotated by the coordinate x, in the first two columns of rows of length ``row``."""
    angle = angle_of(chart, x)
    cosine, sine = np.cos(angle), np.sin(angle)
    for i in range(0, 2 * row, row):
        first, second = g[i], g[i + 1]
        out[i], out[i + 1] = first * cosine + second * sine, second * cosine - first * sine


@jit_inline
def relative_coordinate(chart, g, k, row):
    """Coordinate of the rotation from g to k, in matrices with rows of length ``row``."""
    sine = g[0] * k[row] - g[row] * k[0]
    cosine = g[0] * k[0] + g[row] * k[row]
    return coordinate_of(chart, np.arctan2(sine, cosine))


@jit_inline
def restore_rotation(g, row):
    """One Newton step to orthogonality, in a matrix with rows of length ``row``."""
    half = 1.5 - 0.5 * (g[0] ** 2 + g[row] ** 2)
    cosine, sine = half * g[0], half * g[row]
    g[0], g[1], g[row], g[row + 1] = cosine, -sine, sine, cosine


@jit_inline
def turn_derivative(g, slope, row):
    """The derivative along a rotation of g, in a matrix with rows of length ``row``."""
    total = 0.0
    for i in range(2):
        total += slope[row * i] * g[row * i + 1] - slope[row * i + 1] * g[row * i]
    return total


@jit_inline
def place(chart, g, xi, out):
    """out <- g Phi(xi)."""
    turn(chart, g, xi[0], 2, out)


@jit_inline
def tangent(chart, xi, eta, T, G):
    """T and G, (1, 1)."""
    slope, bend = angle_slopes(chart, xi[0])
    T[0, 0], G[0, 0] = slope, bend * eta[0]


@jit_inline
def coordinates(chart, g, k, xi):
    """xi <- the coordinate of g^T k."""
    xi[0] = relative_coordinate(chart, g, k, 2)


@jit_inline
def restore(g):
    """One Newton step to orthogonality."""
    restore_rotation(g, 2)


@jit_inline
def coadjoint_inverse(chart, xi, mu, out):
    """out <- mu: rotations of the plane commute."""
    out[0] = mu[0]


@jit_inline
def coadjoint(chart, xi, mu, out):
    """out <- mu: rotations of the plane commute."""
    out[0] = mu[0]


@jit_inline
def left_derivative(g, slope, out):
    """out <- the derivative along a rotation."""
    out[0] = turn_derivative(g, slope, 2)


@jit_inline
def position_scale(g):
    """0: a rotation has no position."""
    return 0.0


@jit_inline
def with_rotation(chart, xi, w, out):
    """out <- w."""
    for i in range(w.size):
        out[i] = w[i]
