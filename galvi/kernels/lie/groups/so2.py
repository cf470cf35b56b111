"""Rotations of the plane: matrices (2, 2), and one angular velocity.

Their angle is that of rotations of space about a fixed axis, with coordinate x on it: u = x^2,
cos = 1 - cosine u, sin = sine x, d angle/dx = a + c u (galvi.kernels.lie.charts).
"""

import numpy as np

from galvi.kernels.lie.arithmetic import generic, two_sum
from galvi.kernels.lie.dispatch import coordinate_of, rotation_radial, tangent_radial
from galvi.kernels.lie.elementary import sqrt


@generic
def change(chart, x):
    """cos - 1 and sin of the angle."""
    sine, cosine = rotation_radial(chart, x * x)
    return -(cosine * (x * x)), sine * x


@generic
def slopes(chart, x):
    """d angle/dx and d^2 angle/dx^2."""
    u = x * x
    (a, _, c), (a1, _, c1), _ = tangent_radial(chart, u)
    return a + c * u, 2.0 * x * (a1 + c + c1 * u)


@generic
def turn(chart, g, x, row, out):
    """out <- g rotated by the coordinate x, in the first two columns of rows of length ``row``."""
    cosine_less_one, sine = change(chart, x)
    for i in (0, row):
        first, second = g[i], g[i + 1]
        out[i] = first + (first * cosine_less_one + second * sine)
        out[i + 1] = second + (second * cosine_less_one - first * sine)


@generic
def turn_frame(chart, x, row, g, memory, low):
    """Rotate g in place, as ``turn``; memory (2,) holds cos and sin, which are not normalised, and
    low their low parts."""
    c, s = memory[0], memory[1]
    cosine_less_one, sine = change(chart, x)
    c_change, s_change = c * cosine_less_one - s * sine, s * cosine_less_one + c * sine
    c, low[0] = two_sum(c, low[0] + c_change)
    s, low[1] = two_sum(s, low[1] + s_change)
    memory[0], memory[1] = c, s
    size = sqrt(c * c + s * s)
    g[0], g[1], g[row], g[row + 1] = c / size, -s / size, s / size, c / size


@generic
def relative_coordinate(chart, g, k, row):
    """Coordinate of the rotation from g to k, in matrices with rows of length ``row``."""
    sine = g[0] * k[row] - g[row] * k[0]
    cosine = g[0] * k[0] + g[row] * k[row]
    return coordinate_of(chart, np.arctan2(sine, cosine))


@generic
def restore_rotation(g, row):
    """One Newton step to orthogonality, in a matrix with rows of length ``row``."""
    half = 1.5 - 0.5 * (g[0] ** 2 + g[row] ** 2)
    cosine, sine = half * g[0], half * g[row]
    g[0], g[1], g[row], g[row + 1] = cosine, -sine, sine, cosine


@generic
def turn_derivative(g, slope, row):
    """The derivative along a rotation of g, in a matrix with rows of length ``row``."""
    first = slope[0] * g[1] - slope[1] * g[0]
    return first + (slope[row] * g[row + 1] - slope[row + 1] * g[row])


@generic
def place(chart, g, xi, out):
    turn(chart, g, xi[0], 2, out)


@generic
def velocity(chart, xi, eta, out):
    """out <- T eta = T^T eta."""
    out[0] = slopes(chart, xi[0])[0] * eta[0]


@generic
def rate(chart, xi, v, out):
    """out <- T^-1 v = T^-T v."""
    out[0] = v[0] / slopes(chart, xi[0])[0]


momentum, covector = velocity, rate


@generic
def momentum_slope(chart, xi, eta, mu, out):
    """out <- d(mu T eta)/dxi."""
    out[0] = slopes(chart, xi[0])[1] * (eta[0] * mu[0])


@generic
def coadjoint_change(chart, xi, mu, out):
    """out <- 0: rotations of the plane commute."""
    out[0] = 0.0


@generic
def left_derivative(g, slope, out):
    out[0] = turn_derivative(g, slope, 2)


@generic
def coadjoint(chart, xi, mu, out):
    """out <- mu."""
    out[0] = mu[0]


@generic
def coordinates(chart, g, k, xi):
    xi[0] = relative_coordinate(chart, g, k, 2)


@generic
def restore(g):
    restore_rotation(g, 2)


@generic
def with_rotation(chart, xi, w, out):
    """out <- w."""
    out[0] = w[0]


@generic
def position_scale(g):
    """0: a rotation has no position."""
    return 0.0


@generic
def remember(g, memory):
    """memory <- cos and sin."""
    memory[0], memory[1] = g[0], g[2]


@generic
def advance(chart, xi, g, memory, low):
    turn_frame(chart, xi[0], 2, g, memory, low)


@generic
def in_space(g, mu, out):
    """out <- mu."""
    out[0] = mu[0]


@generic
def carry(chart, g, g1, xi, kick, mu, nu, low):
    """mu <- mu + kick; low is its low part; nu is not used."""
    mu[0], low[0] = two_sum(mu[0], low[0] + kick[0])
