"""A chart of SE(3): (w, v) to the rotation R(w) and the translation V(w) v, and its tangent map.

With u = |w|^2 and V = I + e hat(w) + f hat(w)^2 (galvi.kernels.lie.chart_coefficients), the body's
linear velocity is R^T d(V v)/dt = R^T (M(w, v) w' + V v'), where

    M(w, v) = d(V v)/dw = 2 e1 x1 w^T - e hat(v) + 2 f1 x2 w^T + f (w v^T + (w.v) I - 2 v w^T),
    x1 = w x v,  x2 = w x (w x v) = (w.v) w - u v.

T (6, 6), G (6, 6) as in galvi.kernels.lie.so3; xi = (w, v), eta = (w', v').
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_inline, jit_noalloc
from galvi.kernels.lie.chart_coefficients import translation_radial
from galvi.kernels.lie.so3 import hat, rotation
from galvi.kernels.lie.so3 import tangent as rotation_tangent


@jit_inline
def dot(v, w):
    """v . w in space."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@jit_inline
def cross(v, w):
    """v x w, three numbers."""
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


@jit_inline
def shift_matrix(chart, w, V):
    """V <- I + e hat(w) + f hat(w)^2."""
    u = dot(w, w)
    (e, f), _, _ = translation_radial(chart, u)
    hat(e, w, V)
    for i in range(3):
        for j in range(3):
            V[i, j] += f * w[i] * w[j]
        V[i, i] += 1.0 - f * u


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
    """by_w <- d(M(w, v) wd)/dw and by_v <- d(M(w, v) wd)/dv = dV(w)[wd]; turn, bend room."""
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
    """As ``tangent``, with room (10, 3, 3)."""
    w, v, wd, vd, linear = xi[:3], xi[3:6], eta[:3], eta[3:6], room[9, 0]
    R, V, M, Md, by_w, by_v = room[0], room[1], room[2], room[3], room[4], room[5]
    turning, bending = room[6], room[7]
    shift_curvature(chart, w, v, wd, by_w, by_v, room[8], room[9])
    rotation(chart, w, R)
    rotation_tangent(chart, w, wd, turning, bending)
    shift_matrix(chart, w, V)
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
