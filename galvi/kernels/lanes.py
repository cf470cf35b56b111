"""Vector instructions over the stages of a step, eight at a time.

numba does not vectorise loops whose arrays may overlap; these functions are written in the
compiler's own vector types instead. An array (rows, P), P a multiple of LANES, holds a number for
every stage in each row; the lanes past the last stage repeat it. Sums of products may be fused.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8
DOUBLE = ir.DoubleType()
VECTOR = ir.VectorType(DOUBLE, LANES)
UNDEFINED = ir.Constant(VECTOR, ir.Undefined)
FIRST_LANE = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
FUSED = ("contract",)


class _Lanes:
    """The instructions that the functions below are made of."""

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


@intrinsic
def attract(typingctx, axes, Q, a, masses, i, first, last, padded, chunk):
    """Bodies i and j = first .. last - 1 attract each other, in eight stages.

    a_i += Gm_j g, a_j -= Gm_i g, g = (q_j - q_i) / |q_j - q_i|^3; rows are axes of bodies in turn.
    """
    whole = types.intp
    signature = types.void(axes, Q, a, masses, whole, whole, whole, whole, whole)

    def generate(context, builder, signature, arguments):
        i, first, last, padded, chunk = arguments[4:]
        lanes = _Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        step = ir.Constant(i.type, dimension)
        places, pulls, weights = (lanes.data(signature.args[k], arguments[k]) for k in (1, 2, 3))
        row_i = builder.mul(i, step)
        here = [lanes.load(places, lanes.plus(row_i, x)) for x in range(dimension)]
        mass_i = lanes.spread(lanes.number(weights, i))
        pulled = [lanes.variable(lanes.load(pulls, lanes.plus(row_i, x))) for x in range(dimension)]
        one = ir.Constant(i.type, 1)
        with cgutils.for_range_slice(builder, first, last, one) as (j, _):
            row_j = builder.mul(j, step)
            gaps = [
                lanes.sub(lanes.load(places, lanes.plus(row_j, x)), here[x])
                for x in range(dimension)
            ]
            square = lanes.mul(gaps[0], gaps[0])
            for gap in gaps[1:]:
                square = lanes.add(square, lanes.mul(gap, gap))
            cube = lanes.mul(square, lanes.call("sqrt", square))
            pull = builder.fdiv(ir.Constant(VECTOR, [1.0] * LANES), cube)
            onto_i = lanes.mul(lanes.spread(lanes.number(weights, j)), pull)
            onto_j = lanes.mul(mass_i, pull)
            for x, gap in enumerate(gaps):
                row = lanes.plus(row_j, x)
                lanes.store(lanes.sub(lanes.load(pulls, row), lanes.mul(onto_j, gap)), pulls, row)
                total = lanes.add(builder.load(pulled[x]), lanes.mul(onto_i, gap))
                builder.store(total, pulled[x])
        for x in range(dimension):
            lanes.store(builder.load(pulled[x]), pulls, lanes.plus(row_i, x))
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def combine(typingctx, axes, matrix, start, a, out, body, stages, padded, chunk):
    """out <- sum_j a_j matrix[start + j] for all axes of one body, in eight stages."""
    whole = types.intp
    signature = types.void(axes, matrix, whole, a, out, whole, whole, whole, whole)

    def generate(context, builder, signature, arguments):
        start, body, stages, padded, chunk = (arguments[k] for k in (2, 5, 6, 7, 8))
        lanes = _Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        factors, values, results = (lanes.data(signature.args[k], arguments[k]) for k in (1, 3, 4))
        row = builder.mul(body, ir.Constant(body.type, dimension))
        nothing = [ir.Constant(VECTOR, [0.0] * LANES)] * dimension
        sums = _sums(lanes, nothing, factors, start, values, row, stages)
        for x, total in enumerate(sums):
            lanes.store(total, results, lanes.plus(row, x))
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def move(typingctx, axes, matrix, a, base, low, q, Q, worst, size, body, stages, padded, chunk):
    """Q <- q + (base + (low + sum_j a_j matrix[j])) for all axes of one body, in eight stages.

    worst <- max(worst, size |change of Q|), lane by lane; not a number counts as larger.
    """
    whole, real = types.intp, types.float64
    signature = types.void(
        axes, matrix, a, base, low, q, Q, worst, real, whole, whole, whole, whole
    )

    def generate(context, builder, signature, arguments):
        size, body, stages, padded, chunk = arguments[8:]
        lanes = _Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        factors, values, bases, lows, origin, places, extremes = (
            lanes.data(signature.args[k], arguments[k]) for k in range(1, 8)
        )
        row = builder.mul(body, ir.Constant(body.type, dimension))
        zero = ir.Constant(body.type, 0)
        small = [lanes.load(lows, lanes.plus(row, x)) for x in range(dimension)]
        sums = _sums(lanes, small, factors, zero, values, row, stages)
        scale = lanes.spread(size)
        largest = lanes.load(extremes, zero)
        for x, total in enumerate(sums):
            this = lanes.plus(row, x)
            step = builder.fadd(lanes.load(bases, this), total)
            moved = builder.fadd(lanes.spread(lanes.number(origin, this)), step)
            change = builder.fsub(moved, lanes.load(places, this))
            change = lanes.mul(lanes.call("fabs", change), scale)
            smaller = builder.fcmp_ordered("<", change, largest)
            largest = builder.select(smaller, largest, change)
            lanes.store(moved, places, this)
        lanes.store(largest, extremes, zero)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def drift(typingctx, c, base, low, row, far, far_low, lost, padded, chunk):
    """base <- c far and low <- low + what is too small for it, of one row, in eight stages.

    c    (2, P)  nodes, and what rounding lost of them
    far  h v, ``far_low`` what rounding lost of it, ``lost`` what rounding lost of q
    """
    whole, real = types.intp, types.float64
    signature = types.void(c, base, low, whole, real, real, real, whole, whole)

    def generate(context, builder, signature, arguments):
        row, far, far_low, lost, padded, chunk = arguments[3:]
        lanes = _Lanes(context, builder, padded, chunk)
        nodes, bases, lows = (lanes.data(signature.args[k], arguments[k]) for k in range(3))
        zero = ir.Constant(row.type, 0)
        node, node_low = lanes.load(nodes, zero), lanes.load(nodes, lanes.plus(zero, 1))
        far, far_low, lost = lanes.spread(far), lanes.spread(far_low), lanes.spread(lost)
        place = builder.fmul(node, far)
        error = lanes.call("fma", node, far, builder.fneg(place))
        small = lanes.add(lanes.mul(node_low, far), lanes.mul(node, far_low))
        small = lanes.add(lanes.add(error, lost), small)
        lanes.store(place, bases, row)
        lanes.store(lanes.add(lanes.load(lows, row), small), lows, row)
        return context.get_dummy_value()

    return signature, generate


def _sums(lanes, first, factors, start, values, row, stages):
    """first[x] + sum_j values[row + x, j] factors[start + j], one vector for each axis x."""
    builder = lanes.builder
    sums = [lanes.variable(vector) for vector in first]
    with cgutils.for_range(builder, stages) as loop:
        factor = lanes.load(factors, builder.add(start, loop.index))
        for x in range(len(first)):
            value = lanes.spread(lanes.number(values, lanes.plus(row, x), loop.index))
            builder.store(lanes.add(builder.load(sums[x]), lanes.mul(value, factor)), sums[x])
    return [builder.load(total) for total in sums]
