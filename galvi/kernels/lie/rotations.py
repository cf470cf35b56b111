"""Rotations of space in a chart: xi (3,) to the matrix, its tangent map, and back.

R    (3, 3)  matrix
T    (3, 3)  tangent map, R^T R' = hat(T xi')
G    (3, 3)  d(T(xi) eta)/dxi
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie.arithmetic import cross, dot, generic
from galvi.kernels.lie.chart_functions import from_quaternion, rotation_radial, tangent_radial


@generic
def rotation(chart, xi):
    """I + sine hat(xi) + cosine hat(xi)^2, three rows."""
    x, y, z = xi[0], xi[1], xi[2]
    u = x * x + y * y + z * z
    sine, cosine = rotation_radial(chart, u)
    return (
        (1.0 - cosine * (y * y + z * z), cosine * x * y - sine * z, cosine * x * z + sine * y),
        (cosine * x * y + sine * z, 1.0 - cosine * (x * x + z * z), cosine * y * z - sine * x),
        (cosine * x * z - sine * y, cosine * y * z + sine * x, 1.0 - cosine * (x * x + y * y)),
    )


@generic
def turned(first, second, xi, v):
    """(first hat(xi) + second hat(xi)^2) v, three numbers."""
    once = cross(xi, v)
    twice = cross(xi, once)
    return (
        first * once[0] + second * twice[0],
        first * once[1] + second * twice[1],
        first * once[2] + second * twice[2],
    )


@generic
def transpose(R):
    """The columns of three rows."""
    return (
        (R[0][0], R[1][0], R[2][0]), (R[0][1], R[1][1], R[2][1]), (R[0][2], R[1][2], R[2][2]),
    )  # fmt: skip


@generic
def times(R, v):
    """R v for R given by three rows."""
    return dot(R[0], v), dot(R[1], v), dot(R[2], v)


@jit_inline
def fill(rows, out):
    """out (3, 3) <- three rows."""
    for j in range(3):
        out[0, j], out[1, j], out[2, j] = rows[0][j], rows[1][j], rows[2][j]


@jit_inline
def tangent(chart, xi, eta, T, G):
    """T <- a I - b hat(xi) + c xi xi^T and G <- its product with eta, differentiated by xi."""
    x, y, z = xi[0], xi[1], xi[2]
    u = x * x + y * y + z * z
    (a, b, c), (a1, b1, c1), _ = tangent_radial(chart, u)
    along = x * eta[0] + y * eta[1] + z * eta[2]
    hat(b, xi, T)  # the sign is reversed below
    hat(b, eta, G)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turned = xi[j] * eta[k] - xi[k] * eta[j]
        slope = 2.0 * (a1 * eta[i] - b1 * turned + c1 * along * xi[i])
        for l in range(3):
            T[i, l] = c * xi[i] * xi[l] - T[i, l]
            G[i, l] += slope * xi[l] + c * xi[i] * eta[l]
        T[i, i] += a
        G[i, i] += c * along


@jit_inline
def hat(factor, w, out):
    """out <- factor hat(w), hat(w) v = w x v."""
    for i in range(3):
        out[i, i] = 0.0
    out[0, 1], out[1, 0] = -factor * w[2], factor * w[2]
    out[0, 2], out[2, 0] = factor * w[1], -factor * w[1]
    out[1, 2], out[2, 1] = -factor * w[0], factor * w[0]


@generic
def quaternion(R):
    """A unit quaternion (w, x, y, z) of the rotation with rows R, from its largest component.

    Shepperd, J. Guidance and Control 1 (1978) 223.
    """
    a, b, c = R[0][0], R[1][1], R[2][2]
    x, y, z = R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]
    p, q, r = R[1][0] + R[0][1], R[0][2] + R[2][0], R[2][1] + R[1][2]
    largest = max(a + b + c, a, b, c)
    if largest == a + b + c:
        w, x, y, z = 1.0 + largest, x, y, z
    elif largest == a:
        w, x, y, z = x, 1.0 + a - b - c, p, q
    elif largest == b:
        w, x, y, z = y, p, 1.0 - a + b - c, r
    else:
        w, x, y, z = z, q, r, 1.0 - a - b + c
    length = np.sqrt(w * w + x * x + y * y + z * z)
    return w / length, x / length, y / length, z / length


@jit_inline
def coordinates(chart, R, xi):
    """xi <- the coordinates of the rotation with rows R, by the angle of at most pi."""
    w, x, y, z = quaternion(R)
    factor = from_quaternion(chart, abs(w), np.sqrt(x * x + y * y + z * z))
    factor = -factor if w < 0.0 else factor
    xi[0], xi[1], xi[2] = factor * x, factor * y, factor * z


@jit_noalloc
def orthonormal(R, out):
    """out <- R (3 I - R^T R) / 2: one step of Newton's iteration for the nearest rotation."""
    for i in range(3):
        for j in range(3):
            total = 1.5 * R[i, j]
            for k in range(3):
                square = R[0, k] * R[0, j] + R[1, k] * R[1, j] + R[2, k] * R[2, j]
                total -= 0.5 * R[i, k] * square
            out[i, j] = total
