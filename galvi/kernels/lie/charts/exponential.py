"""The exponential chart: xi = angle axis, Phi = exp(hat(xi)).

sine = a = c1, cosine = b = c2, c = c3 and V = I + c2 hat(xi) + c3 hat(xi)^2, with Stumpff's
functions c_k = sum_j (-u)^j / (2 j + k)!,  dc_k/du = (k c_{k+2} - c_{k+1}) / 2.

In lanes, c6 and c7 are polynomials, and the others follow from them.
"""

import math
from fractions import Fraction

import numpy as np

from galvi.kernels.lie.arithmetic import generic, in_kernels, polynomial

SINGULAR_ANGLE = 2.0 * math.pi
LARGEST_IN_STEP = 0.995 * SINGULAR_ANGLE
LARGEST_IN_LANES = 2.0  # the series for lanes have full accuracy up to here
STUMPFF_TERMS = 12  # terms of the series of c6 and c7, for u below LARGEST_SERIES_U
LARGEST_SERIES_U = 9.0  # from this u on, closed formulas replace the series
INVERSE_FACTORIALS = np.array([1.0 / math.factorial(k) for k in range(10 + 2 * STUMPFF_TERMS)])
# The rounding errors of 1 / k!: they are the same in each step, so that energies would drift.
INVERSE_FACTORIALS_LOW = np.array(
    [
        float(1 / Fraction(math.factorial(k)) - Fraction(x))
        for k, x in enumerate(INVERSE_FACTORIALS[:6].tolist())
    ]
)
LANE_SERIES = [[(-1.0) ** j / math.factorial(2 * j + k) for j in range(11)] for k in (6, 7)]


def stumpff_of_number(u):
    """c1 to c7 at one u >= 0, as a tuple.

    For u below LARGEST_SERIES_U from the series of c6 and c7 by c_k = 1/k! - u c_{k+2}; else from
    c1 and c2 by the same relation upwards, which loses no digits there.
    """
    if u < LARGEST_SERIES_U:
        c6, c7, power = 0.0, 0.0, 1.0
        for j in range(STUMPFF_TERMS):
            c6 += power * INVERSE_FACTORIALS[6 + 2 * j]
            c7 += power * INVERSE_FACTORIALS[7 + 2 * j]
            power *= -u
        c5 = INVERSE_FACTORIALS[5] + (INVERSE_FACTORIALS_LOW[5] - u * c7)
        c4 = INVERSE_FACTORIALS[4] + (INVERSE_FACTORIALS_LOW[4] - u * c6)
        c3 = INVERSE_FACTORIALS[3] + (INVERSE_FACTORIALS_LOW[3] - u * c5)
        c2 = INVERSE_FACTORIALS[2] - u * c4
        return 1.0 - u * c3, c2, c3, c4, c5, c6, c7
    angle = np.sqrt(u)
    half = np.sin(0.5 * angle)
    c1 = np.sin(angle) / angle
    c2 = 2.0 * half * half / u
    c3 = (1.0 - c1) / u
    c4 = (INVERSE_FACTORIALS[2] - c2) / u
    c5 = (INVERSE_FACTORIALS[3] - c3) / u
    return c1, c2, c3, c4, c5, (INVERSE_FACTORIALS[4] - c4) / u, (INVERSE_FACTORIALS[5] - c5) / u


@in_kernels(stumpff_of_number)
def stumpff(u):
    """c1 to c7 at u >= 0, as a tuple; for lanes, at u up to LARGEST_IN_LANES^2."""
    if isinstance(u, float):
        return stumpff_of_number(u)
    c6, c7 = (polynomial(series, u) for series in LANE_SERIES)
    c5 = INVERSE_FACTORIALS[5] + (INVERSE_FACTORIALS_LOW[5] - u * c7)
    c4 = INVERSE_FACTORIALS[4] + (INVERSE_FACTORIALS_LOW[4] - u * c6)
    c3 = INVERSE_FACTORIALS[3] + (INVERSE_FACTORIALS_LOW[3] - u * c5)
    c2 = 0.5 - u * c4
    return 1.0 - u * c3, c2, c3, c4, c5, c6, c7


@generic
def rotation(u):
    c = stumpff(u)
    return c[0], c[1]


@generic
def tangent(u):
    c1, c2, c3, c4, c5, c6, c7 = stumpff(u)
    d2, d3 = 0.5 * (2.0 * c4 - c3), 0.5 * (3.0 * c5 - c4)
    d4, d5 = 0.5 * (4.0 * c6 - c5), 0.5 * (5.0 * c7 - c6)
    first = 0.5 * (c3 - c2), d2, d3
    second = 0.5 * (d3 - d2), 0.5 * (2.0 * d4 - d3), 0.5 * (3.0 * d5 - d4)
    return (c1, c2, c3), first, second


@generic
def inverse(u):
    c = stumpff(u)
    d = 0.5 * (c[2] - 2.0 * c[3]) / c[1]
    return 1.0 - u * d, d


@generic
def translation(u):
    (_, b, c), (_, b1, c1), (_, b2, c2) = tangent(u)
    return (b, c), (b1, c1), (b2, c2)


def half_turn_of_number(u):
    """`half_turn` for a number."""
    half = 0.25 * np.sqrt(u)
    sine = np.sin(half)
    vector_factor = 0.5 * sine * np.cos(half) / half if half > 0.0 else 0.5
    return vector_factor, -2.0 * sine * sine


@in_kernels(half_turn_of_number)
def half_turn(u):
    if not hasattr(u, "call"):
        return half_turn_of_number(u)
    c = stumpff(0.25 * u)
    return 0.5 * c[0], -0.25 * u * c[1]


@generic
def from_quaternion(w, sine):
    return 2.0 * np.arctan2(sine, w) / sine if sine > 1e-150 else 2.0 / w


@generic
def angle(x):
    return x


@generic
def coordinate(angle):
    return angle
