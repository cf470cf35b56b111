"""Elementary functions for laws of motion, of lanes, numbers and arrays alike.

A law is a Python function (q, v, t, constants) -> (dL/dq, dL/dv, mass), where q and v are sequences
of d values, as are dL/dq and dL/dv, and mass holds the rows of d2L/dv2 up to its diagonal. Zeros
that do not depend on the state are the number 0.0, and cost nothing in lanes.
"""

from __future__ import annotations

import numpy as np

from galvi.lanes import functions
from galvi.lanes.values import Lane

MAX_HALVES = 64  # largest 2 |y| for which x^y by products is as accurate as the function


def sin(x):
    """The sine."""
    return sine_cosine(x)[0]


def cos(x):
    """The cosine."""
    return sine_cosine(x)[1]


def sine_cosine(x):
    """(sin x, cos x), computed once for each lane."""
    if not isinstance(x, Lane):
        return np.sin(x), np.cos(x)
    if x.sine_cosine is None:
        x.sine_cosine = functions.sine_cosine(x)
    return x.sine_cosine


def tan(x):
    """The tangent."""
    sine, cosine = sine_cosine(x)
    return sine / cosine


def _for_lanes_and_arrays(lane_function, array_function):
    """A function that calls ``lane_function`` for a lane and ``array_function`` otherwise."""
    return lambda x: lane_function(x) if isinstance(x, Lane) else array_function(x)


exp = _for_lanes_and_arrays(functions.exponential, np.exp)
log = _for_lanes_and_arrays(functions.logarithm, np.log)
sqrt = _for_lanes_and_arrays(functions.square_root, np.sqrt)
sinh = _for_lanes_and_arrays(functions.hyperbolic_sine, np.sinh)
cosh = _for_lanes_and_arrays(functions.hyperbolic_cosine, np.cosh)
tanh = _for_lanes_and_arrays(functions.hyperbolic_tangent, np.tanh)


def over_cube(numerator, square):
    """numerator / r^3 from square = r^2; by an estimate of 1 / r where x has `_reciprocals`."""
    reciprocals = _reciprocals(square)
    if reciprocals is None:
        return numerator / (square * sqrt(square))
    root = reciprocals.root(square)
    return numerator * root * (root * root)


def inverse(x):
    """1 / x; by an estimate where x has `_reciprocals`."""
    reciprocals = _reciprocals(x)
    return 1.0 / x if reciprocals is None else reciprocals.reciprocal(x)


def inverse_seven_quarters(x):
    """x^(-7/4) of a lane; by an estimate of 1 / sqrt(x) where x has `_reciprocals`."""
    reciprocals = _reciprocals(x)
    if reciprocals is None:
        return functions.inverse_fourth_root(x).power_by_products(14)
    return reciprocals.inverse_quarters(x, 7)


def _reciprocals(x):
    """``builder.reciprocals`` of a lane, a `galvi.lanes.functions.Reciprocals`; None for numbers
    and arrays, and for lanes of a kernel that has none."""
    return getattr(getattr(x, "builder", None), "reciprocals", None)


def power(x, y):
    """x^y; for a lane x and a number y, by products if y is a multiple of 1/2, |2 y| <=
    MAX_HALVES."""
    if not (isinstance(x, Lane) or isinstance(y, Lane)):
        return x**y
    if isinstance(x, Lane) and isinstance(y, int | float):
        twice = 2.0 * y
        if twice == int(twice) and abs(twice) <= MAX_HALVES:
            return x.power_by_products(int(twice))
    lane = x if isinstance(x, Lane) else y
    return functions.power(lane.same(x), lane.same(y))


def atan2(y, x):
    """The angle of the point (x, y), from -pi to pi."""
    if isinstance(y, Lane) or isinstance(x, Lane):
        lane = y if isinstance(y, Lane) else x
        return functions.arctangent(lane.same(y), lane.same(x))
    return np.arctan2(y, x)
