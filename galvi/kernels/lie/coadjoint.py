"""Momenta and forces on any group: from one frame to another, and from derivatives by matrices.

layout, chart, g, xi  as in galvi.kernels.lie.charts;  mu, slope  (d,) in the dual of the algebra
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_noalloc
from galvi.kernels.lie import se3, so3
from galvi.kernels.lie.charts import RN, SE3, SO2, SO3, dimension, entries


@jit
def coadjoint_inverse(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)^-1} mu: a body covector at g Phi(xi), seen from the frame of g."""
    start = 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        d = dimension(kind, n)
        for i in range(start, start + d):
            out[i] = mu[i]
        if kind in (SO3, SE3):
            R = np.empty((3, 3))
            so3.rotation(chart, xi[start : start + 3], R)
            for part in range(start, start + d, 3):
                for i in range(3):
                    out[part + i] = se3.dot(R[i], mu[part : part + 3])
        if kind == SE3:
            V, x = np.empty((3, 3)), np.empty(3)
            se3.shift_matrix(chart, xi[start : start + 3], V)
            for i in range(3):
                x[i] = se3.dot(V[i], xi[start + 3 : start + 6])
            lever = se3.cross(x, out[start + 3 : start + 6])
            for i in range(3):
                out[start + i] += lever[i]
        start += d


@jit
def coadjoint(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)} mu, the inverse of ``coadjoint_inverse``."""
    start = 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        d = dimension(kind, n)
        for i in range(start, start + d):
            out[i] = mu[i]
        if kind in (SO3, SE3):
            R, seen = np.empty((3, 3)), np.empty(6)
            so3.rotation(chart, xi[start : start + 3], R)
            for i in range(d):
                seen[i] = mu[start + i]
            if kind == SE3:
                V, x = np.empty((3, 3)), np.empty(3)
                se3.shift_matrix(chart, xi[start : start + 3], V)
                for i in range(3):
                    x[i] = se3.dot(V[i], xi[start + 3 : start + 6])
                lever = se3.cross(x, seen[3:6])
                for i in range(3):
                    seen[i] -= lever[i]
            for part in range(0, d, 3):
                for i in range(3):
                    total = 0.0
                    for k in range(3):
                        total += R[k, i] * seen[part + k]
                    out[start + part + i] = total
        start += d


@jit_noalloc
def pull(layout, g, slope, out):
    """out <- the derivative along g hat(e_a) of a function with Euclidean derivative slope (r,)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        kind, n = layout[factor, 0], layout[factor, 1]
        size, d = entries(kind, n), dimension(kind, n)
        if kind == RN:
            for i in range(n):
                out[start + i] = slope[first + i]
        elif kind == SO2:
            out[start] = 0.0
            for i in range(2):
                row = first + 2 * i
                out[start] += slope[row] * g[row + 1] - slope[row + 1] * g[row]
        else:
            side = 3 if kind == SO3 else 4
            for a in range(3):
                j, k = (a + 1) % 3, (a + 2) % 3
                out[start + a] = 0.0
                for i in range(3):
                    row = first + side * i
                    out[start + a] += g[row + k] * slope[row + j] - g[row + j] * slope[row + k]
            if kind == SE3:
                for a in range(3):
                    out[start + 3 + a] = 0.0
                    for i in range(3):
                        out[start + 3 + a] += g[first + 4 * i + a] * slope[first + 4 * i + 3]
        first, start = first + size, start + d
