"""Rotations of space in a chart: xi (3,) to the matrix, its tangent map, and back.

R    (3, 3)  matrix, three rows
T    (3, 3)  tangent map, R^T R' = hat(T xi'), T xi' = a xi' - b xi x xi' + c (xi . xi') xi
"""

import numpy as np

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie import dispatch
from galvi.kernels.lie.arithmetic import cross, dot, generic, two_sum

ROUNDING_SHIFT = 1.5 * 2.0**26  # a number below 1 plus this is rounded to a multiple of 2^-26


@generic
def rotation(chart, xi):
    """I + sine hat(xi) + cosine hat(xi)^2, three rows."""
    x, y, z = xi[0], xi[1], xi[2]
    u = x * x + y * y + z * z
    sine, cosine = dispatch.rotation_radial(chart, u)
    return (
        (1.0 - cosine * (y * y + z * z), cosine * x * y - sine * z, cosine * x * z + sine * y),
        (cosine * x * y + sine * z, 1.0 - cosine * (x * x + z * z), cosine * y * z - sine * x),
        (cosine * x * z - sine * y, cosine * y * z + sine * x, 1.0 - cosine * (x * x + y * y)),
    )


@generic
def hat_polynomial(first, second, xi, v):
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
    """The transposed matrix, three rows."""
    return (
        (R[0][0], R[1][0], R[2][0]),
        (R[0][1], R[1][1], R[2][1]),
        (R[0][2], R[1][2], R[2][2]),
    )


@generic
def times(R, v):
    """R v for R given by three rows."""
    return dot(R[0], v), dot(R[1], v), dot(R[2], v)


@generic
def change(chart, sign, xi, v):
    """R v - v for sign = 1, R^T v - v for sign = -1."""
    sine, cosine = dispatch.rotation_radial(chart, dot(xi, xi))
    return hat_polynomial(sign * sine, cosine, xi, v)


@generic
def rotated(chart, sign, xi, v):
    """R v for sign = 1, R^T v for sign = -1."""
    x, y, z = change(chart, sign, xi, v)
    return v[0] + x, v[1] + y, v[2] + z


@generic
def tangent(chart, sign, xi, v):
    """T v for sign = 1, T^T v for sign = -1."""
    (a, b, c), _, _ = dispatch.tangent_radial(chart, dot(xi, xi))
    b = -sign * b
    x, y, z = cross(xi, v)
    x, y, z = b * x + a * v[0], b * y + a * v[1], b * z + a * v[2]
    if c == 0.0:
        return x, y, z
    along = c * dot(xi, v)
    return x + along * xi[0], y + along * xi[1], z + along * xi[2]


@generic
def inverse_tangent(chart, sign, xi, v):
    """T^-1 v for sign = 1, T^-T v for sign = -1."""
    k, d = dispatch.inverse_radial(chart, dot(xi, xi))
    x, y, z = cross(xi, v)
    half, along = 0.5 * sign, d * dot(xi, v)
    return (
        (k * v[0] + half * x) + along * xi[0],
        (k * v[1] + half * y) + along * xi[1],
        (k * v[2] + half * z) + along * xi[2],
    )


@generic
def tangent_slope(chart, xi, eta, mu):
    """d(mu . T(xi) eta)/dxi."""
    (_, b, c), (a1, b1, c1), _ = dispatch.tangent_radial(chart, dot(xi, xi))
    x, y, z = cross(eta, mu)
    p, q = dot(xi, eta), dot(xi, mu)
    radial = 2.0 * (a1 * dot(eta, mu) - b1 * (x * xi[0] + y * xi[1] + z * xi[2]))
    if c == 0.0:
        return radial * xi[0] - b * x, radial * xi[1] - b * y, radial * xi[2] - b * z
    radial = radial + 2.0 * c1 * p * q
    return (
        radial * xi[0] - b * x + c * (p * mu[0] + q * eta[0]),
        radial * xi[1] - b * y + c * (p * mu[1] + q * eta[1]),
        radial * xi[2] - b * z + c * (p * mu[2] + q * eta[2]),
    )


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
    """xi <- the coordinates of the rotation with rows R, whose angle is taken in [0, pi]."""
    w, x, y, z = quaternion(R)
    factor = dispatch.from_quaternion(chart, abs(w), np.sqrt(x * x + y * y + z * z))
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


@generic
def turn_quaternion(chart, xi, q, low):
    """q (4,) <- q times the quaternion of xi; low (4,) holds the rounding errors of q.

    q + low is a unit quaternion to about 1e-32. With the rounding error of |q|, which is the same
    for many steps, matrices would be slightly larger or smaller than rotations, and energies drift.
    """
    vector_factor, w_change = dispatch.half_turn(chart, dot(xi, xi))
    a, b, c = vector_factor * xi[0], vector_factor * xi[1], vector_factor * xi[2]
    w, x, y, z = q[0], q[1], q[2], q[3]
    steps = (
        w_change * w - (a * x + b * y + c * z),
        w_change * x + (a * w + c * y - b * z),
        w_change * y + (b * w + a * z - c * x),
        w_change * z + (c * w + b * x - a * y),
    )
    for i in range(4):
        q[i], low[i] = two_sum(q[i], low[i] + steps[i])
    half = 0.5 * norm_defect(q, low)
    for i in range(4):
        low[i] = low[i] + half * q[i]


@generic
def norm_defect(q, low):
    """1 - |q + low|^2, which is small.

    The entries of q are rounded to multiples of 2^-26, the sum of whose squares is exact; the
    remainders are at most 2^-27.
    """
    large, small = 1.0, 0.0
    for i in range(4):
        rounded = (q[i] + ROUNDING_SHIFT) - ROUNDING_SHIFT
        large = large - rounded * rounded
        small = small + ((q[i] - rounded) * (q[i] + rounded) + 2.0 * (q[i] * low[i]))
    return large - small


@generic
def matrix_of(q):
    """The rotation of a unit quaternion (w, x, y, z), three rows."""
    w, x, y, z, two = q[0], q[1], q[2], q[3], 2.0
    return (
        (1.0 - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)),
        (two * (x * y + w * z), 1.0 - two * (x * x + z * z), two * (y * z - w * x)),
        (two * (x * z - w * y), two * (y * z + w * x), 1.0 - two * (x * x + y * y)),
    )
