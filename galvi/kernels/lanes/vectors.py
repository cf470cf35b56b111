"""Operations on eight doubles at a time, in LLVM's vector types.

Each row of an array (rows, P), P a multiple of LANES, holds a number for every stage. Sums of
products may be fused.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils

LANES = 8
DOUBLE = ir.DoubleType()
VECTOR = ir.VectorType(DOUBLE, LANES)
BITS = ir.VectorType(ir.IntType(64), LANES)
UNDEFINED = ir.Constant(VECTOR, ir.Undefined)
FIRST_LANE = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
FUSED = ("contract",)
NOTHING = ir.Constant(VECTOR, [0.0] * LANES)
ONE = ir.Constant(VECTOR, [1.0] * LANES)


class Lanes:
    """Loads, stores and arithmetic on the eight stages of a row that start at 8 chunk.

    builder  LLVM builder of the function being compiled, in its context
    padded   P, the length of a row
    """

    def __init__(self, context, builder, padded, chunk):
        self.context, self.builder = context, builder
        self.padded = padded
        self.offset = builder.mul(chunk, ir.Constant(chunk.type, LANES))

    def data(self, array_type, array):
        return self.context.make_array(array_type)(self.context, self.builder, array).data

    def address(self, data, row):
        place = self.builder.add(self.builder.mul(row, self.padded), self.offset)
        return self.builder.bitcast(self.builder.gep(data, [place]), VECTOR.as_pointer())

    def load(self, data, row):
        value = self.builder.load(self.address(data, row))
        value.align = 8
        return value

    def store(self, value, data, row):
        self.builder.store(value, self.address(data, row)).align = 8

    def factor(self, matrix, row):
        """Numbers of a matrix, one for each stage."""
        return self.load(matrix, row)

    def number(self, data, row, column=None):
        place = row if column is None else self.builder.add(
            self.builder.mul(row, self.padded), column
        )  # fmt: skip
        return self.builder.load(self.builder.gep(data, [place]))

    def spread(self, scalar):
        lane = self.builder.insert_element(UNDEFINED, scalar, ir.Constant(ir.IntType(32), 0))
        return self.builder.shuffle_vector(lane, UNDEFINED, FIRST_LANE)

    def plus(self, row, offset):
        return self.builder.add(row, ir.Constant(row.type, offset)) if offset else row

    def mul(self, x, y):
        return self.builder.fmul(x, y, flags=FUSED)

    def add(self, x, y):
        return self.builder.fadd(x, y, flags=FUSED)

    def sub(self, x, y):
        return self.builder.fsub(x, y, flags=FUSED)

    def call(self, name, *values):
        function = cgutils.get_or_insert_function(
            self.builder.module,
            ir.FunctionType(VECTOR, [VECTOR] * len(values)),
            f"llvm.{name}.v{LANES}f64",
        )
        return self.builder.call(function, values)

    def variable(self, value):
        place = cgutils.alloca_once(self.builder, VECTOR)
        self.builder.store(value, place)
        return place

    def largest(self, bits):
        """The largest lane of a vector of integers."""
        name = f"llvm.vector.reduce.smax.v{LANES}i64"
        kind = ir.FunctionType(BITS.element, [BITS])
        return self.builder.call(
            cgutils.get_or_insert_function(self.builder.module, kind, name), [bits]
        )

    def sums(self, first, factors, start, values, row, stages):
        """first[x] + sum_j values[row + x, j] factors[start + j], one vector for each axis x.

        Even and odd j are summed separately, which halves the chain of dependent additions.
        """
        builder = self.builder
        even = [self.variable(vector) for vector in first]
        odd = [self.variable(NOTHING) for _ in first]
        one, two = ir.Constant(stages.type, 1), ir.Constant(stages.type, 2)

        def add(j, totals):
            factor = self.factor(factors, builder.add(start, j))
            for x, total in enumerate(totals):
                value = self.spread(self.number(values, self.plus(row, x), j))
                builder.store(self.add(builder.load(total), self.mul(value, factor)), total)

        with cgutils.for_range(builder, builder.udiv(stages, two)) as loop:
            add(builder.mul(loop.index, two), even)
            add(builder.add(builder.mul(loop.index, two), one), odd)
        last = builder.trunc(stages, ir.IntType(1))
        with builder.if_then(last):
            add(builder.sub(stages, one), even)
        return [
            self.add(builder.load(one), builder.load(other))
            for one, other in zip(even, odd, strict=True)
        ]

    def pull(self, places, here, row):
        """The vector from ``here`` to the body whose rows start at ``row``, distance^2 and
        1 / distance^3."""
        gaps = [self.sub(self.load(places, self.plus(row, x)), q) for x, q in enumerate(here)]
        square = self.mul(gaps[0], gaps[0])
        for gap in gaps[1:]:
            square = self.add(square, self.mul(gap, gap))
        cube = self.mul(square, self.call("sqrt", square))
        return gaps, square, self.builder.fdiv(ONE, cube)
