"""Rigid motions of space: matrices [[R, x], [0, 1]] (4, 4), velocities (w, v) of the body.

A chart maps (w, v) to the rotation R(w) and the translation V(w) v. With u = |w|^2 and
V = I + e hat(w) + f hat(w)^2 (galvi.kernels.lie.charts), the body's linear velocity is
R^T d(V v)/dt = R^T (M(w, v) w' + V v'), where

    M(w, v) = d(V v)/dw = 2 e1 x1 w^T - e hat(v) + 2 f1 x2 w^T + f (w v^T + (w.v) I - 2 v w^T),
    x1 = w x v,  x2 = w x (w x v) = (w.v) w - u v.

T (6, 6), G (6, 6); xi = (w, v), eta = (w', v').
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_inline, jit_noalloc
from galvi.kernels.lie.arithmetic import cross, dot, generic
from galvi.kernels.lie.chart_functions import translation_radial
from galvi.kernels.lie.groups.so3 import (
    columns,
    relative_coordinates,
    restore_rotation,
    turn_derivatives,
)
from galvi.kernels.lie.rotations import fill, hat, rotation, times, transpose
from galvi.kernels.lie.rotations import tangent as rotation_tangent


@generic
def shift_matrix(chart, w):
    """V, three rows."""
    x, y, z = w[0], w[1], w[2]
    u = dot(w, w)
    (e, f), _, _ = translation_radial(chart, u)
    rest = 1.0 - f * u
    return (
        (f * x * x + rest, f * x * y - e * z, f * x * z + e * y),
        (f * y * x + e * z, f * y * y + rest, f * y * z - e * x),
        (f * z * x - e * y, f * z * y + e * x, f * z * z + rest),
    )


@jit_inline
def shift_slope(chart, w, v, M):
    """M <- d(V(w) v)/dw."""
    u, along = dot(w, w), dot(w, v)
    (e, f), (e1, f1), _ = translation_radial(chart, u)
    x1 = cross(w, v)
    hat(-e, v, M)
    for i in range(3):
        x2 = along * w[i] - u * v[i]
        for j in range(3):
            M[i, j] += 2.0 * (e1 * x1[i] + f1 * x2) * w[j] + f * (w[i] * v[j] - 2.0 * v[i] * w[j])
        M[i, i] += f * along


@jit_inline
def shift_curvature(chart, w, v, wd, by_w, by_v, turn, bend):
    """by_w <- d(M(w, v) wd)/dw and by_v <- d(M(w, v) wd)/dv = dV(w)[wd]; turn, bend scratch."""
    u, along, pace, mixed = dot(w, w), dot(w, v), dot(w, wd), dot(v, wd)
    (e, f), (e1, f1), (e2, f2) = translation_radial(chart, u)
    x1, vxd = cross(w, v), cross(v, wd)
    hat(-2.0 * e1 * pace, v, by_w)
    hat(1.0, w, turn)
    hat(1.0, wd, bend)
    for i in range(3):
        x2 = along * w[i] - u * v[i]
        bent = w[i] * mixed + along * wd[i] - 2.0 * v[i] * pace
        for j in range(3):
            by_w[i, j] += 4.0 * pace * (e2 * x1[i] + f2 * x2) * w[j]
            by_w[i, j] += 2.0 * (e1 * x1[i] + f1 * x2) * wd[j]
            by_w[i, j] += (2.0 * f1 * bent - 2.0 * e1 * vxd[i]) * w[j]
            by_w[i, j] += 2.0 * f1 * pace * (w[i] * v[j] - 2.0 * v[i] * w[j])
            by_w[i, j] += f * (wd[i] * v[j] - 2.0 * v[i] * wd[j])
            square = w[i] * w[j] - (u if i == j else 0.0)
            mix = w[i] * wd[j] + wd[i] * w[j] - (2.0 * pace if i == j else 0.0)
            by_v[i, j] = (
                2.0 * e1 * pace * turn[i, j] + e * bend[i, j] + 2.0 * f1 * pace * square + f * mix
            )
        by_w[i, i] += 2.0 * f1 * pace * along + f * mixed


@jit
def tangent(chart, xi, eta, T, G):
    """T and G of the rigid motion, (6, 6)."""
    tangent_with(chart, xi, eta, np.empty((10, 3, 3)), T, G)


@jit_noalloc
def tangent_with(chart, xi, eta, room, T, G):
    """As ``tangent``, with scratch room (10, 3, 3)."""
    w, v, wd, vd, linear = xi[:3], xi[3:6], eta[:3], eta[3:6], room[9, 0]
    R, V, M, Md, by_w, by_v = room[0], room[1], room[2], room[3], room[4], room[5]
    turning, bending = room[6], room[7]
    shift_curvature(chart, w, v, wd, by_w, by_v, room[8], room[9])
    rotation_tangent(chart, w, wd, turning, bending)
    fill(rotation(chart, w), R)
    fill(shift_matrix(chart, w), V)
    shift_slope(chart, w, v, M)
    shift_slope(chart, w, vd, Md)
    for i in range(3):
        linear[i] = 0.0
    for i in range(3):
        for j in range(3):
            T[i, j], T[i, j + 3] = turning[i, j], 0.0
            G[i, j], G[i, j + 3] = bending[i, j], 0.0
            T[i + 3, j] = T[i + 3, j + 3] = G[i + 3, j] = G[i + 3, j + 3] = 0.0
            for k in range(3):
                T[i + 3, j] += R[k, i] * M[k, j]
                T[i + 3, j + 3] += R[k, i] * V[k, j]
                G[i + 3, j] += R[k, i] * (by_w[k, j] + Md[k, j])
                G[i + 3, j + 3] += R[k, i] * by_v[k, j]
    for i in range(3):
        for j in range(3):
            linear[i] += T[i + 3, j] * wd[j] + T[i + 3, j + 3] * vd[j]
    hat(1.0, linear, by_w)  # d(R^T) y = linear x (T dw)
    for i in range(3):
        for j in range(3):
            for k in range(3):
                G[i + 3, j] += by_w[i, k] * turning[k, j]


@jit_inline
def place(chart, g, xi, out):
    """out <- g Phi(xi)."""
    across, x = transpose(rotation(chart, xi)), times(shift_matrix(chart, xi), xi[3:6])
    for i in range(4):
        row = g[4 * i], g[4 * i + 1], g[4 * i + 2]
        out[4 * i + 3] = dot(row, x) + g[4 * i + 3]
        out[4 * i], out[4 * i + 1], out[4 * i + 2] = times(across, row)


@jit_inline
def coordinates(chart, g, k, xi):
    """xi <- the coordinates of g^-1 k."""
    relative_coordinates(chart, g, k, 4, xi)
    apart = k[3] - g[3], k[7] - g[7], k[11] - g[11]
    shift_to_coordinates(chart, xi, times(columns(g, 4), apart), xi)


@jit
def shift_to_coordinates(chart, w, shift, out):
    """out[3:6] <- V(w)^-1 shift."""
    solved = np.linalg.solve(np.array(shift_matrix(chart, w)), np.array(shift))
    for i in range(3):
        out[3 + i] = solved[i]


@jit_inline
def with_rotation(chart, xi, w, out):
    """out <- w and the translation part with which the motion is that of xi."""
    shift = times(shift_matrix(chart, xi), xi[3:6])
    for i in range(3):
        out[i] = w[i]
    shift_to_coordinates(chart, w, shift, out)


@jit_inline
def restore(g):
    """One Newton step to orthogonality."""
    restore_rotation(g, 4)


@jit_inline
def coadjoint_inverse(chart, xi, mu, out):
    """out <- (R m + x cross R f, R f) for mu = (m, f), where x = V v."""
    R, x = rotation(chart, xi), times(shift_matrix(chart, xi), xi[3:6])
    m, f = times(R, mu), times(R, mu[3:6])
    lever = cross(x, f)
    for i in range(3):
        out[i], out[3 + i] = m[i] + lever[i], f[i]


@jit_inline
def coadjoint(chart, xi, mu, out):
    """out <- (R^T (m - x cross f), R^T f) for mu = (m, f), where x = V v."""
    across, x = transpose(rotation(chart, xi)), times(shift_matrix(chart, xi), xi[3:6])
    lever = cross(x, mu[3:6])
    out[3], out[4], out[5] = times(across, mu[3:6])
    out[0], out[1], out[2] = times(across, (mu[0] - lever[0], mu[1] - lever[1], mu[2] - lever[2]))


@jit_inline
def left_derivative(g, slope, out):
    """out <- the derivatives along rotations and along translations in the body's frame."""
    turn_derivatives(g, slope, 4, out)
    for a in range(3):
        out[3 + a] = 0.0
        for i in range(3):
            out[3 + a] += g[4 * i + a] * slope[4 * i + 3]


@jit_inline
def position_scale(g):
    """The largest coordinate of the position."""
    return max(abs(g[3]), abs(g[7]), abs(g[11]))
