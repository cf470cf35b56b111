"""Arithmetic of triples and polynomials, for numbers in kernels and for lanes of eight.

A function decorated with ``generic`` is compiled into the kernels that call it, and remains a
Python function for calls with lanes (galvi.lanes.values), numbers or arrays of these.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable

from galvi.kernels.compile.parts import part_settings

OPTIONS: Any = part_settings({"error_model": "numpy", "_nrt": False, "forceinline": True})
generic = register_jitable(**OPTIONS)


def in_kernels(compiled):
    """A decorator: kernels that call the decorated function compile ``compiled`` instead of it."""

    def mark(function):
        overload(function, jit_options=OPTIONS, strict=False)(lambda *arguments: compiled)
        return function

    return mark


@generic
def dot(v, w):
    """v . w of two triples."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@generic
def cross(v, w):
    """v x w of two triples."""
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


def where_of_numbers(condition, x, y):
    """x where the condition is true, else y."""
    return x if condition else y


@in_kernels(where_of_numbers)
def where(condition, x, y):
    """x where a condition is true, else y, for numbers, lanes or arrays."""
    if hasattr(condition, "select"):
        return condition.select(x, y)
    if isinstance(condition, np.ndarray):
        return np.where(condition, x, y)
    return where_of_numbers(condition, x, y)


@generic
def larger(x, y):
    """The larger of two numbers, lanes or arrays; y where x or y is NaN."""
    return where(x > y, x, y)


def larger_size_of_numbers(size, x):
    """The larger of size and |x|."""
    return max(size, abs(x))


@in_kernels(larger_size_of_numbers)
def larger_size(size, x):
    """The larger of ``size`` and |x|, for a number or a lane x; ``size`` may be a number for
    both."""
    if not hasattr(x, "where"):
        return larger_size_of_numbers(size, x)
    magnitude = abs(x)
    return magnitude.where(magnitude > size, size)


@generic
def two_sum(x, y):
    """The rounded sum of x and y and its error, x + y = sum + error (Knuth)."""
    total = x + y
    part = total - x
    return total, (x - (total - part)) + (y - part)


def polynomial(coefficients, u):
    """sum_k coefficients[k] u^k, evaluated in pairs so that products can run in parallel."""
    square, total = u * u, 0.0
    for even, odd in reversed(list(zip_longest(coefficients[::2], coefficients[1::2]))):
        total = square * total + (even if odd is None else u * odd + even)
    return total
