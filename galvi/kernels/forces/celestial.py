"""Forces between point masses other than Newton's gravity.

A pull depends on the gap from a source to a target body. It gives the target the acceleration a
and, per unit of its mass, the energy phi, a = -dphi/dgap; the source recoils.

terms      (rows, COLUMNS)  SOURCE and TARGET, RECOIL = m_target / m_source, WEIGHT = m_target, then
                            numbers of ``pole_pull`` or ``power_pull``; those of ``pole_pull`` first
constants  those of galvi.kernels.forces.nbody, then the number of rows, that of rows of
           ``pole_pull``, and the terms
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit
from galvi.kernels.constants import COMPLEX_STEP
from galvi.kernels.forces.nbody import accelerations as attractions
from galvi.kernels.lie.arithmetic import dot, generic, in_kernels
from galvi.kernels.lie.elementary import log, sqrt

SOURCE, TARGET, RECOIL, WEIGHT, FIRST_NUMBER = range(5)
COLUMNS = FIRST_NUMBER + 6


@generic
def pole_pull(gap, numbers):
    """a and phi (4,) of phi = K / (2 r^2) + K2 P2(u) / r^3 + K4 P4(u) / r^5, u = pole . gap / r.

    Parameters
    ----------
    numbers
        pole (3,), a unit vector, K, K2 and K4
    """
    pole, inverse_cube, second, fourth = numbers[:3], numbers[3], numbers[4], numbers[5]
    inverse = 1.0 / dot(gap, gap)
    height = dot(gap, pole)
    u, root = height * height * inverse, sqrt(inverse)
    inverse_r4 = inverse * inverse
    cube, outer = root * inverse_r4, fourth * inverse
    gap_factor = inverse_cube * inverse_r4 + cube * (
        second * (7.5 * u - 1.5) + outer * (1.875 + u * (39.375 * u - 26.25))
    )
    pole_factor = cube * height * (3.0 * second + outer * (17.5 * u - 7.5))
    phi = 0.5 * inverse_cube * inverse + root * inverse * (
        second * (1.5 * u - 0.5) + outer * (0.375 + u * (4.375 * u - 3.75))
    )
    return (
        gap_factor * gap[0] - pole_factor * pole[0],
        gap_factor * gap[1] - pole_factor * pole[1],
        gap_factor * gap[2] - pole_factor * pole[2],
        phi,
    )


def power_of_number(x, power):
    """x^power of a number."""
    return x**power


@in_kernels(power_of_number)
def power_of(x, power):
    """x^power of numbers or of lanes."""
    return x.power(power) if hasattr(x, "call") else x**power


@generic
def power_pull(gap, numbers):
    """a and phi (4,) of the acceleration A r^n away from the source.

    Parameters
    ----------
    numbers
        A, n, -A / (n + 1) and 0; for n = -1: A, n, 0 and -A / 2
    """
    square = dot(gap, gap)
    power = power_of(square, 0.5 * (numbers[1] - 1.0))
    gap_factor = numbers[0] * power
    phi = numbers[2] * (square * power) + numbers[3] * log(square)
    return gap_factor * gap[0], gap_factor * gap[1], gap_factor * gap[2], phi


@jit
def accelerations(Q, t, constants, out):
    """Accelerations as of galvi.kernels.forces.nbody, plus those of the terms."""
    attractions(Q, t, constants, out)
    dimension = int(constants[0])
    head = 1 + Q.shape[0] // dimension
    rows, poles = int(constants[head]), int(constants[head + 1])
    for term in range(rows):
        row = constants[head + 2 + term * COLUMNS : head + 2 + (term + 1) * COLUMNS]
        i, j = int(row[SOURCE]) * dimension, int(row[TARGET]) * dimension
        numbers = (row[4], row[5], row[6], row[7], row[8], row[9])
        for k in range(Q.shape[1]):
            z = Q[j + 2, k] - Q[i + 2, k] if dimension == 3 else 0.0
            gap = (Q[j, k] - Q[i, k], Q[j + 1, k] - Q[i + 1, k], z)
            pull = pole_pull(gap, numbers) if term < poles else power_pull(gap, numbers)
            for x in range(dimension):
                out[j + x, k] += pull[x]
                out[i + x, k] -= row[RECOIL] * pull[x]


@jit
def lagrangian(g, v, t, constants, out):
    """The law of L = sum m |v|^2 / 2 - V, see galvi.kernels.forces.lagrangian_derivatives.

    Parameters
    ----------
    constants
        m of each coordinate (d,), then those of ``accelerations``
    """
    d = v.size
    Q, time, pull = np.empty((d, 1)), np.empty(1), np.empty((d, 1))
    Q[:, 0], time[0] = g, t
    accelerations(Q, time, constants[d:], pull)
    for i in range(d):
        out[0, i], out[1, i] = constants[i] * v[i], constants[i] * pull[i, 0]


def pulls(terms, poles, q):
    """Accelerations (..., bodies, D) and energies (...) of terms at q, real or complex."""
    a, energy = np.zeros(q.shape, q.dtype), np.zeros(q.shape[:-2], q.dtype)
    for k, row in enumerate(terms):
        i, j = int(row[SOURCE]), int(row[TARGET])
        gap = [q[..., j, x] - q[..., i, x] for x in range(q.shape[-1])] + [0.0]
        *pull, phi = (pole_pull if k < poles else power_pull)(gap[:3], row[FIRST_NUMBER:])
        for x in range(q.shape[-1]):
            a[..., j, x] += pull[x]
            a[..., i, x] -= row[RECOIL] * pull[x]
        energy += row[WEIGHT] * phi
    return a, energy


def pulls_slope(terms, poles, q):
    """The derivative (d, d) of the accelerations at q (bodies, D), by complex steps."""
    moved = q + 1j * COMPLEX_STEP * np.eye(q.size).reshape(-1, *q.shape)
    return np.imag(pulls(terms, poles, moved)[0]).reshape(q.size, q.size).T / COMPLEX_STEP
