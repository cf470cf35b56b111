"""Arithmetic on eight stages at once, written as on numbers, for functions in galvi.kernels.lanes.

A Lane wraps a vector that a compiler builds; sums of products may be fused.
"""

from __future__ import annotations

from llvmlite import ir

from galvi.kernels.vectors import FUSED, LANES, VECTOR


class Lane:
    """Eight doubles; +, -, *, / with another Lane or a number."""

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

    def __truediv__(self, other):
        return Lane(self.builder, self.builder.fdiv(self.value, self._lane(other)))

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
    square = u * u
    total = None
    for k in range(len(coefficients) - len(coefficients) % 2, -1, -2):
        pair = coefficients[k : k + 2]
        if not pair:
            continue
        term = u * pair[1] + pair[0] if len(pair) == 2 else pair[0]
        total = term if total is None else total * square + term
    return total
