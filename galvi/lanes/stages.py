"""Vector instructions at all stages of a step of point masses, on rows of arrays.

Each function is called with the form of the kernel, then with arrays, integers and real numbers.
The first row of a body is its index times the dimension.

form  two tuples, whose lengths are the dimension and the number of lanes of a vector; s, the number
      of stages; and P, s padded to full vectors
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.functions import Reciprocals
from galvi.lanes.values import Lane
from galvi.lanes.vectors import DOUBLE, Lanes

CHANGE, SIZE = 0, 1  # rows of changes for velocities; two more for positions follow


class Rows:
    """Rows of an array at a vector of stages; an index is an integer, or (LLVM integer, offset)."""

    def __init__(self, at, array):
        self.at, self.data = at, array

    def row(self, index):
        return self.at.plus(*index) if isinstance(index, tuple) else self.at.padded.type(index)

    def __getitem__(self, index):
        return Lane(self.at.builder, self.at.load(self.data, self.row(index)))

    def __setitem__(self, index, lane):
        self.at.store(lane.value, self.data, self.row(index))

    def number(self, *index):
        """A number of a one-dimensional array, in all lanes."""
        return Lane(self.at.builder, self.at.spread(self.at.number(self.data, self.row(index))))


class Stages(Lanes):
    """A vector of stages of a step, for point masses."""

    def __init__(self, context, builder, form, form_value, chunk):
        super().__init__(
            context, builder, builder.extract_value(form_value, 3), chunk, form[1].count
        )
        self.stages, self.axes = builder.extract_value(form_value, 2), range(form[0].count)
        self.inverse, self.none = Reciprocals(context, builder), Lane(builder, self.zero)

    def argument(self, kind, value):
        """An argument: rows of an array, a float in all lanes, or an integer."""
        if isinstance(kind, types.Array):
            return Rows(self, self.pointer_to(kind, value))
        return Lane(self.builder, self.spread(value)) if isinstance(kind, types.Float) else value

    def sums_of(self, matrix, values, row):
        """sum_j values_j matrix_j for each axis of the body whose first row is ``row``."""
        first = [self.zero] * len(self.axes)
        sums = self.sums(first, matrix.data, row.type(0), values.data, row, self.stages)
        return [Lane(self.builder, total) for total in sums]

    def average_slopes(self, slopes, row, new, new_share, changes, first):
        """Replace the slopes of a body by new_share * new + (1 - new_share) * old, and add |new -
        old| and |new| to rows ``first`` and ``first + 1`` of ``changes``."""
        changed, size = changes[first + CHANGE], changes[first + SIZE]
        for x, slope in enumerate(new):
            old = slopes[row, x]
            changed, size = changed + abs(slope - old), size + abs(slope)
            slopes[row, x] = new_share * slope + (1.0 - new_share) * old
        changes[first + CHANGE], changes[first + SIZE] = changed, size


def square(vector):
    """|vector|^2."""
    return sum((component * component for component in vector[1:]), vector[0] * vector[0])


def in_lanes(code, returned=types.void):
    """An intrinsic (form, *arguments) that runs ``code(stages, *arguments)`` at all stages of a
    step.

    If ``returned`` is a float type, it returns the sum over all lanes of the `Lane` that ``code``
    returns.
    """

    @intrinsic
    def stage_function(typingctx, form, *arguments):
        def generate(context, builder, signature, values):
            unpacked = [builder.extract_value(values[1], i) for i in range(len(arguments))]
            padded, width = builder.extract_value(values[0], 3), form.types[1].count
            kind = ir.VectorType(DOUBLE, width)
            total = cgutils.alloca_once_value(builder, ir.Constant(kind, [0.0] * width))
            chunks = builder.udiv(padded, padded.type(width))
            with cgutils.for_range(builder, chunks, intp=padded.type) as loop:
                at = Stages(context, builder, form.types, values[0], loop.index)
                contribution = code(at, *map(at.argument, arguments, unpacked))
                if contribution is not None:
                    builder.store(at.add(builder.load(total), contribution.value), total)
            if returned == types.void:
                return context.get_dummy_value()
            name = f"llvm.vector.reduce.fadd.v{width}f64"
            reduction_type = ir.FunctionType(DOUBLE, [DOUBLE, kind])
            add = cgutils.get_or_insert_function(builder.module, reduction_type, name)
            return builder.call(add, [DOUBLE(-0.0), builder.load(total)], fastmath=("reassoc",))

        return returned(form, types.StarArgTuple(arguments)), generate

    return stage_function
