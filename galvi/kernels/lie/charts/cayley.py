"""The Cayley chart: xi = 2 tan(angle / 2) axis, Phi = (I - hat(xi) / 2)^-1 (I + hat(xi) / 2).

sine = a = 1 / (1 + u / 4), cosine = b = a / 2, c = 0, V = (I - hat(xi) / 2)^-1.
"""

import math

import numpy as np

from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.elementary import sqrt

SINGULAR_ANGLE = math.pi
LARGEST_IN_STEP = 2.0 * math.tan(0.5 * 0.995 * math.pi)
LARGEST_IN_LANES = 20.0  # a rotation by nearly pi


@generic
def rotation(u):
    a = 1.0 / (1.0 + 0.25 * u)
    return a, 0.5 * a


@generic
def tangent(u):
    a = 1.0 / (1.0 + 0.25 * u)
    a1 = -0.25 * a * a
    a2 = 0.125 * a * a * a
    return (a, 0.5 * a, 0.0), (a1, 0.5 * a1, 0.0), (a2, 0.5 * a2, 0.0)


@generic
def inverse(u):
    return 1.0, 0.25


@generic
def translation(u):
    a = 1.0 / (1.0 + 0.25 * u)
    a1 = -0.25 * a * a
    a2 = 0.125 * a * a * a
    return (0.5 * a, 0.25 * a), (0.5 * a1, 0.25 * a1), (0.5 * a2, 0.25 * a2)


@generic
def half_turn(u):
    length = sqrt(1.0 + 0.25 * u)
    return 0.5 / length, -0.25 * u / (length * (length + 1.0))


@generic
def from_quaternion(w, sine):
    """factor: xi = factor (x, y, z); infinite at the chart's limit pi."""
    return 2.0 / w


@generic
def angle(x):
    return 2.0 * np.arctan(0.5 * x)


@generic
def coordinate(angle):
    return 2.0 * np.tan(0.5 * angle)
