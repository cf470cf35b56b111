"""Rows of numbers for eight members: loads, stores and sums over the stages of a step.

An array (rows, s, 8) holds a number for each stage and member, one of (rows, 8) a number for each
member, and a matrix (rows, s) the same number for all members.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils

from galvi.fast.lanes.values import Lane, Truth
from galvi.fast.lanes.vectors import DOUBLE, LANES, NOTHING, VECTOR, Lanes, spread

WIDEST = 6  # rows that are summed together: sums stay in registers
ALL = ir.Constant(ir.VectorType(ir.IntType(1), LANES), [1] * LANES)


class MemberLanes(Lanes):
    """Loads and stores of eight members at one stage, with the interface of `Lanes`."""

    def __init__(self, context, builder, stages, stage):
        self.stages, self.stage = stages, stage
        width = builder.mul(stages, ir.Constant(stages.type, LANES))
        super().__init__(context, builder, width, stage)

    def factor(self, matrix, row):
        """A number of a matrix at this stage, in all lanes."""
        place = self.builder.add(self.builder.mul(row, self.stages), self.stage)
        scalar = self.builder.load(self.builder.gep(matrix, [place]))
        return super().spread(scalar)

    def number(self, data, row, column=None):
        """Numbers of the members: of a row (8,), or of one (s, 8) at a stage."""
        eight = ir.Constant(row.type, LANES)
        if column is None:
            place = self.builder.mul(row, eight)
        else:
            column = self.builder.mul(column, eight)
            place = self.builder.add(self.builder.mul(row, self.padded), column)
        address = self.builder.bitcast(self.builder.gep(data, [place]), VECTOR.as_pointer())
        value = self.builder.load(address)
        value.align = 8
        return value

    def spread(self, vector):
        """The same: each member has its own number."""
        return vector

    def sums(self, first, factors, start, values, row, stages):
        """As `Lanes.sums`, for a few rows at a time."""
        found = []
        for k in range(0, len(first), WIDEST):
            part = first[k : k + WIDEST]
            found += super().sums(part, factors, start, values, self.plus(row, k), stages)
        return found

    def keep(self, vector, data, row):
        """Store one number for each member, in a row (8,)."""
        place = self.builder.mul(row, ir.Constant(row.type, LANES))
        address = self.builder.bitcast(self.builder.gep(data, [place]), VECTOR.as_pointer())
        self.builder.store(vector, address).align = 8


class Mask:
    """A truth value for each member that changes, at first true."""

    def __init__(self, builder):
        self.builder = builder
        self.place = cgutils.alloca_once(builder, ALL.type)
        builder.store(ALL, self.place)

    @property
    def value(self):
        """The current truth values."""
        return Truth(self.builder, self.builder.load(self.place))

    def set(self, truth):
        """Change them."""
        self.builder.store(truth.value, self.place)


class Variable:
    """A number for each member that changes."""

    def __init__(self, builder, number=0.0):
        self.builder = builder
        self.place = cgutils.alloca_once(builder, VECTOR)
        self.set(number)

    @property
    def lane(self):
        """The current numbers, whose operations are rounded one by one."""
        return Lane(self.builder, self.builder.load(self.place), ())

    def set(self, number):
        """Change them, to a lane or one number for all."""
        zero = Lane(self.builder, NOTHING, ())
        self.builder.store(zero.same(number).value, self.place)


def splat(builder, scalar):
    """One number in all lanes."""
    return Lane(builder, spread(builder, scalar, LANES), ())


def whole_number(builder, whole):
    """An integer as a number in all lanes."""
    return splat(builder, builder.uitofp(whole, DOUBLE))
