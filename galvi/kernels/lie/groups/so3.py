"""Rotations of space: matrices (3, 3), and three angular velocities of the body."""

import numpy as np

from galvi.kernels.compile.jit import jit
from galvi.kernels.lie import rotations
from galvi.kernels.lie.arithmetic import generic, two_sum
from galvi.kernels.lie.rotations import rotation, times, transpose


@generic
def fill(triple, out):
    """out (3,) <- three numbers."""
    out[0], out[1], out[2] = triple


@generic
def columns(g, row):
    """Three columns of a matrix with rows of length ``row``."""
    return (
        (g[0], g[row], g[2 * row]),
        (g[1], g[row + 1], g[2 * row + 1]),
        (g[2], g[row + 2], g[2 * row + 2]),
    )


@generic
def relative_coordinates(chart, g, k, row, xi):
    """xi <- coordinates of the rotation from g to k, in matrices with rows of length ``row``."""
    start, end = columns(g, row), columns(k, row)
    relative_rotation = times(end, start[0]), times(end, start[1]), times(end, start[2])
    rotations.coordinates(chart, relative_rotation, xi)


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


@generic
def turn_derivatives(g, slope, row, out):
    """out (3,) <- the derivatives along rotations of g, in a matrix with rows of length ``row``."""
    for a in range(3):
        j, k = (a + 1) % 3, (a + 2) % 3
        total = g[k] * slope[j] - g[j] * slope[k]
        for i in (row, 2 * row):
            total = total + (g[i + k] * slope[i + j] - g[i + j] * slope[i + k])
        out[a] = total


@generic
def turn_frame(chart, xi, row, g, memory, low):
    """R <- R Phi(xi) in rows of length ``row``; memory (4,) is a quaternion, low its low part."""
    rotations.turn_quaternion(chart, xi, memory, low)
    R = rotations.matrix_of(memory)
    for i in range(3):
        g[row * i], g[row * i + 1], g[row * i + 2] = R[i]


@generic
def place(chart, g, xi, out):
    columns = transpose(rotation(chart, xi))
    for i in range(3):
        row = g[3 * i], g[3 * i + 1], g[3 * i + 2]
        out[3 * i], out[3 * i + 1], out[3 * i + 2] = times(columns, row)


@generic
def velocity(chart, xi, eta, out):
    fill(rotations.tangent(chart, 1.0, xi, eta), out)


@generic
def rate(chart, xi, v, out):
    fill(rotations.inverse_tangent(chart, 1.0, xi, v), out)


@generic
def momentum(chart, xi, mu, out):
    fill(rotations.tangent(chart, -1.0, xi, mu), out)


@generic
def covector(chart, xi, pi, out):
    fill(rotations.inverse_tangent(chart, -1.0, xi, pi), out)


@generic
def momentum_slope(chart, xi, eta, mu, out):
    fill(rotations.tangent_slope(chart, xi, eta, mu), out)


@generic
def coadjoint_change(chart, xi, mu, out):
    """out <- R mu - mu."""
    fill(rotations.change(chart, 1.0, xi, mu), out)


@generic
def left_derivative(g, slope, out):
    turn_derivatives(g, slope, 3, out)


@generic
def coadjoint(chart, xi, mu, out):
    """out <- R^T mu."""
    fill(rotations.rotated(chart, -1.0, xi, mu), out)


@generic
def coordinates(chart, g, k, xi):
    relative_coordinates(chart, g, k, 3, xi)


@generic
def restore(g):
    restore_rotation(g, 3)


@generic
def with_rotation(chart, xi, w, out):
    """out <- w."""
    out[0], out[1], out[2] = w[0], w[1], w[2]


@generic
def position_scale(g):
    """0: a rotation has no position."""
    return 0.0


@generic
def remember(g, memory):
    """memory <- a quaternion."""
    remember_frame(3, g, memory)


@generic
def remember_frame(row, g, memory):
    """memory <- the quaternion of R in a matrix with rows of length ``row``."""
    start = rotations.quaternion(transpose(columns(g, row)))
    memory[0], memory[1], memory[2], memory[3] = start


@generic
def advance(chart, xi, g, memory, low):
    turn_frame(chart, xi, 3, g, memory, low)


@generic
def in_space(g, mu, out):
    """out <- R mu."""
    fill(times(transpose(columns(g, 3)), mu), out)


@generic
def carry(chart, g, g1, xi, kick, mu, nu, low):
    """nu <- nu + R kick, and mu <- nu in the frame of g1. Only torques change nu, so that rounding
    errors of mu do not add up."""
    impulse = times(transpose(columns(g, 3)), kick)
    for i in range(3):
        nu[i], low[i] = two_sum(nu[i], low[i] + impulse[i])
    fill(times(columns(g1, 3), nu), mu)
