"""Operations on eight doubles at a time, or on another number of them, in LLVM's vector types.

Each row of an array (rows, P), P a multiple of the lanes of a vector, holds a number for every
stage. Sums of products may be fused.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils, cpu_target, event
from galvi.kernels.compile.watching import GENERATED

LANES, NARROW_LANES = 8, 4  # numbers of doubles in a vector
DOUBLE = ir.DoubleType()
VECTOR = ir.VectorType(DOUBLE, LANES)
BITS = ir.VectorType(ir.IntType(64), LANES)
FUSED = ("contract",)
# Processor time in seconds to compile an instruction of a generated law with AVX-512; without, a
# vector of eight fills two registers, and it takes twice as long (12 ball joints in a chain: 57,000
# instructions, 6 s).
SECONDS_PER_INSTRUCTION = 1e-4
ZEROS = ir.Constant(VECTOR, [0.0] * LANES)


def has_avx512(context):
    """Whether numba's context compiles for a processor with AVX-512."""
    return "+avx512f" in context.codegen().magic_tuple()[2].split(",")


AVX512 = has_avx512(cpu_target.target_context)


def lanes_for(stages):
    """The number of lanes of a vector for steps of ``stages`` stages.

    Without AVX-512 a register has four lanes. Of the two registers of a vector of eight, the second
    would be idle for 1 to 4, 9 to 12, ... stages.
    """
    return NARROW_LANES if 1 <= stages % LANES <= NARROW_LANES and not AVX512 else LANES


def announce_compilation(builder):
    """Broadcast the estimated compilation time of a function to the listeners of GENERATED."""
    count = sum(len(block.instructions) for block in builder.function.blocks)
    seconds = SECONDS_PER_INSTRUCTION * count * (1 if AVX512 else 2)
    event.broadcast(event.Event(GENERATED, event.EventStatus.START, {"seconds": seconds}))


def address_intrinsic(generate_code):
    """An intrinsic of the address of integers, whose code ``generate_code(context, builder,
    pointer to the integers)`` generates."""

    @intrinsic
    def run_at_address(typingctx, address):
        signature = types.void(types.int64)

        def generate(context, builder, signature, values):
            generate_code(
                context, builder, builder.inttoptr(values[0], values[0].type.as_pointer())
            )
            announce_compilation(builder)
            return context.get_dummy_value()

        return signature, generate

    return run_at_address


def everywhere(kind, number):
    """The constant vector of type ``kind`` with ``number`` in all lanes."""
    return ir.Constant(kind, [number] * kind.count)


def spread(builder, scalar, lanes):
    """A vector of ``lanes`` lanes, all of which hold ``scalar``."""
    undefined = ir.Constant(ir.VectorType(scalar.type, lanes), ir.Undefined)
    int32 = ir.IntType(32)
    first = builder.insert_element(undefined, scalar, int32(0))
    return builder.shuffle_vector(first, undefined, everywhere(ir.VectorType(int32, lanes), 0))


class Lanes:
    """Loads, stores and arithmetic on ``width`` stages of a row, from stage width * chunk on.

    Parameters
    ----------
    context, builder
        LLVM builder of the function that is generated, and numba's context
    padded
        P, the length of a row, a multiple of the width
    width
        number of lanes of a vector
    """

    def __init__(self, context, builder, padded, chunk, width=LANES):
        self.context, self.builder = context, builder
        self.padded, self.width = padded, width
        self.kind = ir.VectorType(DOUBLE, width)
        self.zero = everywhere(self.kind, 0.0)
        self.offset = builder.mul(chunk, ir.Constant(chunk.type, width))

    def pointer_to(self, array_type, array):
        return self.context.make_array(array_type)(self.context, self.builder, array).data

    def address(self, array, row):
        index = self.builder.add(self.builder.mul(row, self.padded), self.offset)
        return self.builder.bitcast(self.builder.gep(array, [index]), self.kind.as_pointer())

    def load(self, array, row):
        value = self.builder.load(self.address(array, row))
        value.align = 8
        return value

    def store(self, value, array, row):
        self.builder.store(value, self.address(array, row)).align = 8

    def factor(self, matrix, row):
        """The numbers of a row of a matrix, one for each stage."""
        return self.load(matrix, row)

    def number(self, array, row, column=None):
        index = (
            row if column is None else self.builder.add(self.builder.mul(row, self.padded), column)
        )
        return self.builder.load(self.builder.gep(array, [index]))

    def spread(self, scalar):
        return spread(self.builder, scalar, self.width)

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
            ir.FunctionType(self.kind, [self.kind] * len(values)),
            f"llvm.{name}.v{self.width}f64",
        )
        return self.builder.call(function, values)

    def variable(self, value):
        pointer = cgutils.alloca_once(self.builder, self.kind)
        self.builder.store(value, pointer)
        return pointer

    def largest(self, bits):
        """The largest of a vector of signed integers."""
        name = f"llvm.vector.reduce.smax.v{self.width}i64"
        kind = ir.FunctionType(bits.type.element, [bits.type])
        return self.builder.call(
            cgutils.get_or_insert_function(self.builder.module, kind, name), [bits]
        )

    def sums(self, first, factors, start, values, row, stages):
        """first[x] + sum_j values[row + x, j] factors[start + j], one vector for each axis x.

        Even and odd j are summed separately, which halves the chain of dependent additions.
        """
        builder = self.builder
        even = [self.variable(vector) for vector in first]
        odd = [self.variable(self.zero) for _ in first]
        unit, two = ir.Constant(stages.type, 1), ir.Constant(stages.type, 2)

        def add(j, totals):
            factor = self.factor(factors, builder.add(start, j))
            for x, total in enumerate(totals):
                value = self.spread(self.number(values, self.plus(row, x), j))
                builder.store(self.add(builder.load(total), self.mul(value, factor)), total)

        with cgutils.for_range(builder, builder.udiv(stages, two)) as loop:
            add(builder.mul(loop.index, two), even)
            add(builder.add(builder.mul(loop.index, two), unit), odd)
        stages_are_odd = builder.trunc(stages, ir.IntType(1))
        with builder.if_then(stages_are_odd):
            add(builder.sub(stages, unit), even)
        return [
            self.add(builder.load(even_sum), builder.load(odd_sum))
            for even_sum, odd_sum in zip(even, odd, strict=True)
        ]

    def pull(self, places, position, row):
        """The vector from ``position`` to the body whose rows start at ``row``, distance^2 and
        1 / distance^3."""
        gaps = [self.sub(self.load(places, self.plus(row, x)), q) for x, q in enumerate(position)]
        square = self.mul(gaps[0], gaps[0])
        for gap in gaps[1:]:
            square = self.add(square, self.mul(gap, gap))
        cube = self.mul(square, self.call("sqrt", square))
        return gaps, square, self.builder.fdiv(everywhere(self.kind, 1.0), cube)
