"""Arithmetic operators on eight stages at once.

A Lane wraps an LLVM vector under construction; sums of products may be fused.
"""

from __future__ import annotations

from llvmlite import ir

from galvi.kernels.lanes.vectors import FUSED, LANES, VECTOR


class Lane:
    """Eight doubles, with +, - and * by another Lane or a number, and division of a number."""

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
