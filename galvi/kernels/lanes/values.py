"""Arithmetic on eight stages at once, written as on numbers, for functions in
galvi.kernels.lanes.gravity.

A Lane wraps a vector that a compiler builds; sums of products may be fused.
"""

from __future__ import annotations

from itertools import zip_longest

from llvmlite import ir

from galvi.kernels.lanes.vectors import FUSED, LANES, VECTOR


class Lane:
    """Eight doubles; +, - and * with another Lane or a number, and a number over them."""

    def __init__(self, builder, value):
        self.builder, self.value = builder, value

    def _lane(self, other):
        if isinstance(other, Lane):
            return other.value
        return ir.Constant(VECTOR, [float(other)] * LANES)

    def __add__(self, other):
        return Lane(self.builder, self.builder.fadd(self.value, self._lane(other), flags=FUSED))

    def __sub__(self, other):
        return Lane(self.builder, self.builder.fsub(self.value, self._lane(other), flags=FUSED))

    def __mul__(self, other):
        return Lane(self.builder, self.builder.fmul(self.value, self._lane(other), flags=FUSED))

    def __rtruediv__(self, other):
        return Lane(self.builder, self.builder.fdiv(self._lane(other), self.value))

    def __rsub__(self, other):
        return Lane(self.builder, self.builder.fsub(self._lane(other), self.value, flags=FUSED))

    __radd__, __rmul__ = __add__, __mul__


def dot(v, w):
    """v . w of two triples."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


def cross(v, w):
    """v x w of two triples."""
    return [v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]]


def polynomial(coefficients, u):
    """sum_k coefficients[k] u^k, in pairs, so that products overlap."""
    square, total = u * u, 0.0
    for even, odd in reversed(list(zip_longest(coefficients[::2], coefficients[1::2]))):
        total = square * total + (even if odd is None else u * odd + even)
    return total
