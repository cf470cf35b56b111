"""Elementary functions for laws of motion: of numbers, complex or not, of arrays and lanes.

Kernels compile the form for numbers; galvi.lanes.elementary has the form for lanes.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.lie.arithmetic import in_kernels


def for_lanes_too(of_numbers):
    """The function for numbers and arrays, extended to lanes by the function of the same name in
    galvi.lanes.elementary."""

    @in_kernels(of_numbers)
    def function(*arguments):
        if any(hasattr(argument, "builder") for argument in arguments):
            from galvi.lanes import elementary  # galvi.lanes imports this module

            return getattr(elementary, of_numbers.__name__)(*arguments)
        return of_numbers(*arguments)

    return function


@for_lanes_too
def sine_cosine(x):
    """(sin x, cos x)."""
    return np.sin(x), np.cos(x)


@for_lanes_too
def sin(x):
    """The sine."""
    return np.sin(x)


@for_lanes_too
def exp(x):
    """The exponential."""
    return np.exp(x)


@for_lanes_too
def log(x):
    """The natural logarithm."""
    return np.log(x)


@for_lanes_too
def sqrt(x):
    """The square root."""
    return np.sqrt(x)


@for_lanes_too
def atan2(y, x):
    """The angle of the point (x, y)."""
    return np.arctan2(y, x)


@for_lanes_too
def over_cube(numerator, square):
    """numerator / r^3, from r^2."""
    return numerator / (square * np.sqrt(square))


@for_lanes_too
def inverse_seven_quarters(x):
    """x^(-7/4)."""
    return np.sqrt(np.sqrt(x)) / (x * x)
