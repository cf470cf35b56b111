"""The functions of u = |xi|^2 that a chart of rotations is made of.

Rotation        R = I + sine hat(xi) + cosine hat(xi)^2
tangent map     T = a I - b hat(xi) + c xi xi^T,   R^T R' = hat(T xi')
                with derivatives a1 = da/du, a2 = d^2a/du^2, and so on

Cayley          xi = 2 tan(angle / 2) axis: sine = a = 1 / (1 + u / 4), cosine = b = a / 2, c = 0
exponential     xi = angle axis: sine = a = c1, cosine = b = c2, c = c3, with Stumpff's functions
                c_k = sum_j (-u)^j / (2 j + k)!,  dc_k/du = (k c_{k+2} - c_{k+1}) / 2
"""

from __future__ import annotations

import math

import numpy as np

from galvi.kernels.compile.jit import jit_inline

CAYLEY, EXPONENTIAL = 0, 1
TERMS = 12  # of the series of c6 and c7, for u up to SMALL
SMALL = 9.0
ONE_OVER = np.array([1.0 / math.factorial(k) for k in range(10 + 2 * TERMS)])


@jit_inline
def stumpff(u):
    """c1 to c7 at u >= 0, as a tuple.

    For u below SMALL by the series of c6 and c7 and c_k = 1/k! - u c_{k+2}; above by c1 and c2 and
    the same relation upwards, which loses no digits there.
    """
    if u < SMALL:
        c6, c7, power = 0.0, 0.0, 1.0
        for j in range(TERMS):
            c6 += power * ONE_OVER[6 + 2 * j]
            c7 += power * ONE_OVER[7 + 2 * j]
            power *= -u
        c5 = ONE_OVER[5] - u * c7
        c4 = ONE_OVER[4] - u * c6
        c3 = ONE_OVER[3] - u * c5
        c2 = ONE_OVER[2] - u * c4
        return 1.0 - u * c3, c2, c3, c4, c5, c6, c7
    angle = np.sqrt(u)
    half = np.sin(0.5 * angle)
    c1 = np.sin(angle) / angle
    c2 = 2.0 * half * half / u
    c3 = (1.0 - c1) / u
    c4 = (ONE_OVER[2] - c2) / u
    c5 = (ONE_OVER[3] - c3) / u
    return c1, c2, c3, c4, c5, (ONE_OVER[4] - c4) / u, (ONE_OVER[5] - c5) / u


@jit_inline
def rotation_radial(chart, u):
    """(sine, cosine) of the rotation."""
    if chart == CAYLEY:
        a = 1.0 / (1.0 + 0.25 * u)
        return a, 0.5 * a
    c = stumpff(u)
    return c[0], c[1]


@jit_inline
def tangent_radial(chart, u):
    """((a, b, c), (a1, b1, c1), (a2, b2, c2)) of the tangent map."""
    if chart == CAYLEY:
        a = 1.0 / (1.0 + 0.25 * u)
        a1 = -0.25 * a * a
        a2 = 0.125 * a * a * a
        return (a, 0.5 * a, 0.0), (a1, 0.5 * a1, 0.0), (a2, 0.5 * a2, 0.0)
    c1, c2, c3, c4, c5, c6, c7 = stumpff(u)
    d2, d3 = 0.5 * (2.0 * c4 - c3), 0.5 * (3.0 * c5 - c4)
    d4, d5 = 0.5 * (4.0 * c6 - c5), 0.5 * (5.0 * c7 - c6)
    first = 0.5 * (c3 - c2), d2, d3
    second = 0.5 * (d3 - d2), 0.5 * (2.0 * d4 - d3), 0.5 * (3.0 * d5 - d4)
    return (c1, c2, c3), first, second


@jit_inline
def inverse_radial(chart, u):
    """(k, d) of T^-1 = k I + hat(xi) / 2 + d hat(xi)^2."""
    if chart == CAYLEY:
        return 1.0 + 0.25 * u, 0.25
    c = stumpff(u)
    return 1.0, 0.5 * (c[2] - 2.0 * c[3]) / c[1]


@jit_inline
def translation_radial(chart, u):
    """((e, f), (e1, f1), (e2, f2)) of V = I + e hat(xi) + f hat(xi)^2, which moves the origin.

    A rigid motion's chart takes (xi, v) to the rotation of xi and the translation V v.
    """
    if chart == CAYLEY:
        a = 1.0 / (1.0 + 0.25 * u)
        a1 = -0.25 * a * a
        a2 = 0.125 * a * a * a
        return (0.5 * a, 0.25 * a), (0.5 * a1, 0.25 * a1), (0.5 * a2, 0.25 * a2)
    (_, b, c), (_, b1, c1), (_, b2, c2) = tangent_radial(chart, u)
    return (b, c), (b1, c1), (b2, c2)
