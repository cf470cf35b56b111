"""Charts of any group: base point times the chart of xi, tangent maps, coordinates.

layout  (factors, 2)  number of each factor's group (galvi.groups.group), and the n of an R^n
chart   radial.CAYLEY or radial.EXPONENTIAL; R^n and SO(2) look alike in both but for SO(2)'s angle
g       (r,)  an element, the entries of all factors; xi, eta (d,) in the algebra
T, G    (d, d)  g^-1 g' = T(xi) xi',  G = d(T(xi) eta)/dxi; blocks on the diagonal
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_inline
from galvi.kernels.lie import se3, so3
from galvi.kernels.lie.chart_coefficients import CAYLEY

RN, SO2, SO3, SE3 = 0, 1, 2, 3


@jit_inline
def dimension(kind, n):
    """Of one factor's algebra."""
    return n if kind == RN else (1 if kind == SO2 else (3 if kind == SO3 else 6))


@jit_inline
def entries(kind, n):
    """Of one factor's element."""
    return n if kind == RN else (4 if kind == SO2 else (9 if kind == SO3 else 16))


@jit_inline
def angle_of(chart, x):
    """The angle of a plane rotation with coordinate x."""
    return 2.0 * np.arctan(0.5 * x) if chart == CAYLEY else x


@jit
def motion(chart, xi, out):
    """out <- (4, 4) of the chart of SE(3)."""
    R, V = np.empty((3, 3)), np.empty((3, 3))
    so3.rotation(chart, xi, R)
    se3.shift_matrix(chart, xi, V)
    for i in range(3):
        for j in range(3):
            out[i, j] = R[i, j]
        out[i, 3] = se3.dot(V[i], xi[3:6])
        out[3, i] = 0.0
    out[3, 3] = 1.0


@jit
def place(layout, chart, g, xi, out):
    """out <- g Phi(xi)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        size, d = entries(kind, n), dimension(kind, n)
        if kind == RN:
            for i in range(n):
                out[first + i] = g[first + i] + xi[start + i]
        else:
            side = 2 if kind == SO2 else (3 if kind == SO3 else 4)
            turn = np.empty((side, side))
            if kind == SO2:
                angle = angle_of(chart, xi[start])
                turn[0, 0] = turn[1, 1] = np.cos(angle)
                turn[1, 0] = np.sin(angle)
                turn[0, 1] = -turn[1, 0]
            elif kind == SO3:
                so3.rotation(chart, xi[start : start + 3], turn)
            else:
                motion(chart, xi[start : start + 6], turn)
            for i in range(side):
                for j in range(side):
                    total = 0.0
                    for k in range(side):
                        total += g[first + side * i + k] * turn[k, j]
                    out[first + side * i + j] = total
        first, start = first + size, start + d


@jit
def tangent(layout, chart, xi, eta, T, G):
    """T and G of all factors."""
    start = 0
    for i in range(T.shape[0]):
        for j in range(T.shape[1]):
            T[i, j] = G[i, j] = 0.0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        d = dimension(kind, n)
        if kind == RN:
            for i in range(start, start + d):
                T[i, i] = 1.0
        elif kind == SO2:
            x = xi[start]
            T[start, start] = 1.0 / (1.0 + 0.25 * x * x) if chart == CAYLEY else 1.0
            if chart == CAYLEY:
                G[start, start] = -0.5 * x * T[start, start] ** 2 * eta[start]
        else:
            own = slice(start, start + d)
            if kind == SO3:
                so3.tangent(chart, xi[own], eta[own], T[own, own], G[own, own])
            else:
                se3.tangent(chart, xi[own], eta[own], T[own, own], G[own, own])
        start += d


@jit
def coordinates(layout, chart, g, k, xi):
    """xi <- the coordinates of k in the chart at g: k = g Phi(xi)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        size, d = entries(kind, n), dimension(kind, n)
        if kind == RN:
            for i in range(n):
                xi[start + i] = k[first + i] - g[first + i]
        elif kind == SO2:
            sine = g[first] * k[first + 2] - g[first + 2] * k[first]
            cosine = g[first] * k[first] + g[first + 2] * k[first + 2]
            angle = np.arctan2(sine, cosine)
            xi[start] = 2.0 * np.tan(0.5 * angle) if chart == CAYLEY else angle
        else:
            side = 3 if kind == SO3 else 4
            turn = np.empty((3, 3))
            for i in range(3):
                for j in range(3):
                    turn[i, j] = 0.0
                    for l in range(3):
                        turn[i, j] += g[first + side * l + i] * k[first + side * l + j]
            so3.coordinates(chart, turn, xi[start : start + 3])
            if kind == SE3:
                V, shift = np.empty((3, 3)), np.zeros(3)
                se3.shift_matrix(chart, xi[start : start + 3], V)
                for i in range(3):
                    for l in range(3):
                        shift[i] += g[first + 4 * l + i] * (
                            k[first + 4 * l + 3] - g[first + 4 * l + 3]
                        )
                solved = np.linalg.solve(V, shift)
                for i in range(3):
                    xi[start + 3 + i] = solved[i]
        first, start = first + size, start + d


@jit
def restore(layout, g):
    """Bring rotations back to orthogonality, from which rounding takes them: one Newton step."""
    first = 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        if kind == SO2:
            half = 1.5 - 0.5 * (g[first] ** 2 + g[first + 2] ** 2)
            cosine, sine = half * g[first], half * g[first + 2]
            g[first], g[first + 1], g[first + 2], g[first + 3] = cosine, -sine, sine, cosine
        elif kind != RN:
            side = 3 if kind == SO3 else 4
            R, out = np.empty((3, 3)), np.empty((3, 3))
            for i in range(3):
                for j in range(3):
                    R[i, j] = g[first + side * i + j]
            so3.orthonormal(R, out)
            for i in range(3):
                for j in range(3):
                    g[first + side * i + j] = out[i, j]
        first += entries(kind, n)


@jit
def largest_turn(layout, xi):
    """The largest |xi| of a rotation in it, 0 without one."""
    start, largest = 0, 0.0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        if kind != RN:
            size, square = 0.0, 0.0
            for i in range(1 if kind == SO2 else 3):
                size = max(size, abs(xi[start + i]))
            for i in range(1 if kind == SO2 else 3):
                square += (xi[start + i] / size) ** 2 if size > 0.0 else 0.0
            largest = max(largest, size * np.sqrt(square))
        start += dimension(kind, n)
    return largest
