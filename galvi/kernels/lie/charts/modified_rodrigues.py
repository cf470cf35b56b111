"""Modified Rodrigues parameters: xi = 4 tan(angle / 4) axis, Phi = Cayley(xi / 2)^2.

With m = u / 16 and n = 1 / (1 + m):

sine = a = (1 - m) n^2, cosine = b = n^2 / 2, c = n^2 / 8, T^-1 = (1 + m) I + hat / 2 + hat^2 / 8
V = (I - hat(xi) / 4)^-2:  e = n^2 / 2, f = (3 + m) n^2 / 16,   and dn/du = -n^2 / 16

Schaub and Junkins, J. Astronautical Sciences 44 (1996) 1, whose parameters are xi / 4.
"""

import math

import numpy as np

from galvi.kernels.lie.arithmetic import generic

SINGULAR_ANGLE = 2.0 * math.pi
LARGEST_IN_STEP = 4.0 * math.tan(0.25 * 0.995 * SINGULAR_ANGLE)
LARGEST_IN_LANES = 40.0  # a rotation by nearly 2 pi


@generic
def rotation(u):
    m = 0.0625 * u
    n = 1.0 / (1.0 + m)
    return (1.0 - m) * n * n, 0.5 * n * n


@generic
def tangent(u):
    m = 0.0625 * u
    n = 1.0 / (1.0 + m)
    b = 0.5 * n * n
    b1 = -0.0625 * n * n * n
    b2 = 0.01171875 * n * n * n * n  # 3 / 256
    a1 = 0.0625 * n * n * (1.0 - 4.0 * n)
    a2 = 0.0078125 * n * n * n * (6.0 * n - 1.0)
    return (
        (2.0 * (1.0 - m) * b, b, 0.25 * b),
        (a1, b1, 0.25 * b1),
        (a2, b2, 0.25 * b2),
    )


@generic
def inverse(u):
    return 1.0 - 0.0625 * u, 0.125


@generic
def translation(u):
    n = 1.0 / (1.0 + 0.0625 * u)
    e = 0.5 * n * n
    e1 = -0.0625 * n * n * n
    e2 = 0.01171875 * n * n * n * n
    f = 0.0625 * n * (2.0 * n + 1.0)
    f1 = -0.00390625 * n * n * (4.0 * n + 1.0)
    f2 = 0.00048828125 * n * n * n * (6.0 * n + 1.0)
    return (e, f), (e1, f1), (e2, f2)


@generic
def half_turn(u):
    m = 0.0625 * u
    n = 1.0 / (1.0 + m)
    return 0.5 * n, -2.0 * m * n


@generic
def from_quaternion(w, sine):
    return 4.0 / (1.0 + w)


@generic
def angle(x):
    return 4.0 * np.arctan(0.25 * x)


@generic
def coordinate(angle):
    return 4.0 * np.tan(0.25 * angle)
