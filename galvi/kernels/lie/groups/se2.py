"""Rigid motions of the plane: matrices [[R, x], [0, 1]] (3, 3), velocities (omega, v_x, v_y).

A chart of rotations maps (x, v) to the rotation R by angle(x) and the translation V v, with
V = (1 - f x^2) I + e x J, J = [[0, -1], [1, 0]], and e and f at u = x^2
(galvi.kernels.lie.charts); the matrix p I + q J is stored as (p, q).
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.chart_functions import angle_of, angle_slopes, translation_radial
from galvi.kernels.lie.groups.so2 import (
    relative_coordinate,
    restore_rotation,
    turn,
    turn_derivative,
)


@generic
def times(matrix, v, w):
    """(p I + q J) (v, w)."""
    p, q = matrix
    return p * v - q * w, q * v + p * w


@generic
def shift_matrix(chart, x):
    """V, dV/dx and d^2V/dx^2."""
    u = x * x
    (e, f), (e1, f1), (e2, f2) = translation_radial(chart, u)
    return (
        (1.0 - f * u, e * x),
        (-2.0 * x * (f + u * f1), e + 2.0 * u * e1),
        (-2.0 * f - u * (10.0 * f1 + 4.0 * u * f2), x * (6.0 * e1 + 4.0 * u * e2)),
    )


@jit_inline
def place(chart, g, xi, out):
    """out <- g Phi(xi)."""
    turn(chart, g, xi[0], 3, out)
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    out[2] = g[2] + (g[0] * x + g[1] * y)
    out[5] = g[5] + (g[3] * x + g[4] * y)
    out[6], out[7], out[8] = g[6], g[7], g[8]


@jit_inline
def tangent(chart, xi, eta, T, G):
    """T and G: with S = R^T, T eta = (angle' eta_0, S (V' v eta_0 + V eta_v))."""
    x, turning = xi[0], eta[0]
    slope, bend = angle_slopes(chart, x)
    angle = angle_of(chart, x)
    S = np.cos(angle), -np.sin(angle)
    V, V1, V2 = shift_matrix(chart, x)
    by_x = times(S, *times(V1, xi[1], xi[2]))
    first, second = times(S, V[0], V[1]), times(S, V1[0], V1[1])  # S V and S V' as (p, q)
    moved = times(first, eta[1], eta[2])
    linear = by_x[0] * turning + moved[0], by_x[1] * turning + moved[1]
    bent = times(S, *times(V2, xi[1], xi[2]))
    late = times(second, eta[1], eta[2])
    T[0, 0], G[0, 0] = slope, bend * turning
    T[1, 0], T[2, 0] = by_x
    T[1, 1] = T[2, 2] = first[0]
    T[2, 1], T[1, 2] = first[1], -first[1]
    G[1, 0] = bent[0] * turning + late[0] + slope * linear[1]
    G[2, 0] = bent[1] * turning + late[1] - slope * linear[0]
    G[1, 1] = G[2, 2] = second[0] * turning
    G[2, 1], G[1, 2] = second[1] * turning, -second[1] * turning


@jit_inline
def shift_to_coordinates(chart, x, shift):
    """V^-1 shift."""
    (p, q), _, _ = shift_matrix(chart, x)
    size = p * p + q * q
    return times((p / size, -q / size), shift[0], shift[1])


@jit_inline
def coordinates(chart, g, k, xi):
    """xi <- the coordinates of g^-1 k."""
    xi[0] = relative_coordinate(chart, g, k, 3)
    shift = times((g[0], -g[3]), k[2] - g[2], k[5] - g[5])
    xi[1], xi[2] = shift_to_coordinates(chart, xi[0], shift)


@jit_inline
def restore(g):
    """One Newton step to orthogonality."""
    restore_rotation(g, 3)


@jit_inline
def rotation_and_shift(chart, xi):
    """R as (p, q), and the translation V v."""
    angle = angle_of(chart, xi[0])
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    return np.cos(angle), np.sin(angle), x, y


@jit_inline
def coadjoint_inverse(chart, xi, mu, out):
    """out <- (m + x cross R f, R f) for mu = (m, f)."""
    cosine, sine, x, y = rotation_and_shift(chart, xi)
    v, w = times((cosine, sine), mu[1], mu[2])
    out[0], out[1], out[2] = mu[0] + (x * w - y * v), v, w


@jit_inline
def coadjoint(chart, xi, mu, out):
    """out <- (m - x cross f, R^T f) for mu = (m, f)."""
    cosine, sine, x, y = rotation_and_shift(chart, xi)
    v, w = times((cosine, -sine), mu[1], mu[2])
    out[0], out[1], out[2] = mu[0] - (x * mu[2] - y * mu[1]), v, w


@jit_inline
def left_derivative(g, slope, out):
    """out <- the derivatives along a rotation and along translations in the body's frame."""
    out[0] = turn_derivative(g, slope, 3)
    for a in range(2):
        out[1 + a] = g[a] * slope[2] + g[3 + a] * slope[5]


@jit_inline
def position_scale(g):
    """The largest coordinate of the position."""
    return max(abs(g[2]), abs(g[5]))


@jit_inline
def with_rotation(chart, xi, w, out):
    """out <- w and the translation part with which the motion is that of xi."""
    V, _, _ = shift_matrix(chart, xi[0])
    shift = times(V, xi[1], xi[2])
    out[0] = w[0]
    out[1], out[2] = shift_to_coordinates(chart, w[0], shift)
