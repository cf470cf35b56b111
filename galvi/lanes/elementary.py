"""Functions that a law of motion is written in, for lanes, numbers and arrays alike.

A law is a Python function (q, v, t, constants) -> (dL/dq, dL/dv, mass), where q and v are sequences
of d values, dL/dq and dL/dv too, and mass holds the rows of d2L/dv2 up to its diagonal. Zeros that
do not depend on the state are the number 0.0, and cost nothing in lanes.
"""

from __future__ import annotations

import numpy as np

from galvi.lanes import functions
from galvi.lanes.values import Lane

MAX_HALVES = 64  # beyond, a power by products is less accurate than the function


def sin(x):
    """The sine."""
    return sine_cosine(x)[0]


def cos(x):
    """The cosine."""
    return sine_cosine(x)[1]


def sine_cosine(x):
    """Both, computed once for each lane."""
    if not isinstance(x, Lane):
        return np.sin(x), np.cos(x)
    if x.sine_cosine is None:
        x.sine_cosine = functions.sine_cosine(x)
    return x.sine_cosine


def tan(x):
    """The tangent."""
    sine, cosine = sine_cosine(x)
    return sine / cosine


def _either(of_lane, plain):
    """A function of a lane, or of numbers and arrays."""
    return lambda x: of_lane(x) if isinstance(x, Lane) else plain(x)


exp = _either(functions.exponential, np.exp)
log = _either(functions.logarithm, np.log)
sqrt = _either(functions.square_root, np.sqrt)
sinh = _either(functions.hyperbolic_sine, np.sinh)
cosh = _either(functions.hyperbolic_cosine, np.cosh)
tanh = _either(functions.hyperbolic_tangent, np.tanh)


def over_cube(numerator, square):
    """numerator / r^3, from r^2; by an estimate of 1 / r where the kernel has `_reciprocals`."""
    reciprocals = _reciprocals(square)
    if reciprocals is None:
        return numerator / (square * sqrt(square))
    root = reciprocals.root(square)
    return numerator * root * (root * root)


def inverse(x):
    """1 / x; by an estimate where the kernel has `_reciprocals`."""
    reciprocals = _reciprocals(x)
    return 1.0 / x if reciprocals is None else reciprocals.reciprocal(x)


def inverse_seven_quarters(x):
    """x^(-7/4) of a lane; by an estimate of 1 / sqrt(x) where its kernel has `_reciprocals`."""
    reciprocals = _reciprocals(x)
    if reciprocals is None:
        return functions.inverse_fourth_root(x).power_by_products(14)
    return reciprocals.quarters(x, 7)


def _reciprocals(x):
    """``builder.reciprocals`` of a lane, a `galvi.lanes.functions.Reciprocals`,
    where its kernel has them."""
    return getattr(getattr(x, "builder", None), "reciprocals", None)


def power(x, y):
    """x to the power y; by products where y is a small multiple of 1/2."""
    if not (isinstance(x, Lane) or isinstance(y, Lane)):
        return x**y
    if isinstance(x, Lane) and isinstance(y, int | float):
        twice = 2.0 * y
        if twice == int(twice) and abs(twice) <= MAX_HALVES:
            return x.power_by_products(int(twice))
    lane = x if isinstance(x, Lane) else y
    return functions.power(lane.same(x), lane.same(y))


def atan2(y, x):
    """The angle of the point (x, y)."""
    if isinstance(y, Lane) or isinstance(x, Lane):
        lane = y if isinstance(y, Lane) else x
        return functions.arctangent(lane.same(y), lane.same(x))
    return np.arctan2(y, x)
