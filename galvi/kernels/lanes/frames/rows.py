"""Vector instructions of `galvi.kernels.lanes.frames.collocation` on its rows of stages."""

from __future__ import annotations

import math

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.kernels.lanes.functions import sine_cosine
from galvi.kernels.lanes.values import Lane
from galvi.kernels.lanes.vectors import BITS, DOUBLE, LANES, NOTHING, Lanes

UNROLLED = 8  # stages for which sums are written out
BLOCK = 4  # rows that are done together
TIME, OFFSET, WEIGHT, PLACE, PACE = range(5)  # rows of nodes
TURNS, ECCENTRICITY, PHASE = range(3)  # of a clock
TWO_PI = 2.0 * math.pi


def _arrays(context, builder, signature, values, which):
    return [context.make_array(signature.args[k])(context, builder, values[k]) for k in which]


@intrinsic
def place_rows(typingctx, matrix, k, q, v, W, sizes, measure):
    """W <- the state + the sums of k by the rows of the matrix; returns the largest change.

    matrix   (s, P)         A^T of the collocation
    k, W     (2 n, P)       slopes and states at the stages: n rows of places, n of velocities
    q, v     (n or more,)   the state
    sizes    (2 n,)         1 / sizes of the rows; the change is relative to them, NaN the largest
    measure  whether it is wanted; else 0
    """
    signature = types.float64(matrix, k, q, v, W, sizes, types.boolean)

    def generate(context, builder, signature, values):
        table, slopes, places, speeds, out, scales = _arrays(
            context, builder, signature, values, range(6)
        )
        padded = builder.extract_value(out.shape, 1)
        row = padded.type
        stages = builder.extract_value(table.shape, 0)
        rows = builder.udiv(builder.extract_value(out.shape, 0), row(2))
        largest = cgutils.alloca_once(builder, BITS)
        builder.store(ir.Constant(BITS, [0] * LANES), largest)

        def do_rows(lanes, first, origin, offset, count, written_out):
            r = builder.add(first, offset)
            if written_out:
                factors = [lanes.load(table.data, row(j)) for j in range(UNROLLED)]
                totals = []
                for i in range(count):
                    parts = [NOTHING, NOTHING]
                    for j, factor in enumerate(factors):
                        value = lanes.spread(lanes.number(slopes.data, lanes.plus(r, i), row(j)))
                        parts[j % 2] = lanes.add(parts[j % 2], lanes.mul(value, factor))
                    totals.append(lanes.add(*parts))
            else:
                totals = lanes.sums([NOTHING] * count, table.data, row(0), slopes.data, r, stages)
            for i, total in enumerate(totals):
                begin = lanes.spread(lanes.number(origin, lanes.plus(first, i)))
                moved = lanes.add(begin, total)
                this = lanes.plus(r, i)
                with builder.if_then(values[6]):
                    scale = lanes.spread(lanes.number(scales.data, this))
                    far = Lane(builder, builder.fsub(moved, lanes.load(out.data, this)))
                    bits = abs(far * Lane(builder, scale)).bits
                    before = builder.load(largest)
                    # Bit patterns of nonnegative numbers are ordered like these, with NaN last.
                    more = builder.icmp_signed(">", bits, before)
                    builder.store(builder.select(more, bits, before), largest)
                lanes.store(moved, out.data, this)

        def all_rows(written_out):
            chunks = builder.udiv(padded, row(LANES))
            with cgutils.for_range(builder, chunks, intp=row) as outer:
                lanes = Lanes(context, builder, padded, outer.index)
                for half, origin in enumerate((places.data, speeds.data)):
                    offset = builder.mul(rows, row(half))
                    blocks = builder.udiv(rows, row(BLOCK))
                    with cgutils.for_range(builder, blocks, intp=row) as loop:
                        first = builder.mul(loop.index, row(BLOCK))
                        do_rows(lanes, first, origin, offset, BLOCK, written_out)
                    done = builder.mul(blocks, row(BLOCK))
                    rest = builder.sub(rows, done)
                    with cgutils.for_range(builder, rest, intp=row) as loop:
                        do_rows(
                            lanes, builder.add(done, loop.index), origin, offset, 1, written_out
                        )

        with builder.if_else(builder.icmp_unsigned("==", stages, row(UNROLLED))) as (eight, other):
            with eight:
                all_rows(True)
            with other:
                all_rows(False)
        lanes = Lanes(context, builder, padded, row(0))
        return builder.bitcast(lanes.largest(builder.load(largest)), DOUBLE)

    return signature, generate


@intrinsic
def add_rows(typingctx, b, k, high, low, first, rows):
    """high + low <- high + low + sum_j b_j k_j, compensated, for ``rows`` rows of k from ``first``.

    b    (P,)            weights, 0 in the lanes after the last stage
    k    (2 n, P)        slopes at the stages
    high, low  (n or more,)
    """
    whole = types.intp
    signature = types.void(b, k, high, low, whole, whole)

    def generate(context, builder, signature, values):
        weights, slopes, highs, lows = _arrays(context, builder, signature, values, range(4))
        padded = builder.extract_value(slopes.shape, 1)
        row = padded.type
        first, rows = values[4:]
        chunks = builder.udiv(padded, row(LANES))
        with cgutils.for_range(builder, rows, intp=row) as loop:
            this = builder.add(first, loop.index)
            total = cgutils.alloca_once_value(builder, NOTHING)
            with cgutils.for_range(builder, chunks, intp=row) as inner:
                lanes = Lanes(context, builder, padded, inner.index)
                weight = Lane(builder, lanes.load(weights.data, row(0)))
                product = weight * Lane(builder, lanes.load(slopes.data, this))
                builder.store((product + Lane(builder, builder.load(total))).value, total)
            x = added_up(builder, builder.load(total))
            place = builder.gep(highs.data, [loop.index])
            place_low = builder.gep(lows.data, [loop.index])
            high, rest = _two_sum(builder, builder.load(place), x)
            rest = builder.fadd(rest, builder.load(place_low))
            high, rest = _two_sum(builder, high, rest)
            builder.store(high, place)
            builder.store(rest, place_low)
        return context.get_dummy_value()

    return signature, generate


def added_up(builder, vector):
    """The sum of eight lanes, by halves."""
    width = LANES
    while width > 1:
        width //= 2
        kind = ir.VectorType(ir.IntType(32), width)
        undefined = ir.Constant(vector.type, ir.Undefined)
        low, high = (
            builder.shuffle_vector(
                vector, undefined, ir.Constant(kind, list(range(k * width, (k + 1) * width)))
            )
            for k in range(2)
        )
        vector = builder.fadd(low, high)
    return builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))


def _two_sum(builder, x, y):
    total = builder.fadd(x, y)
    part = builder.fsub(total, x)
    one = builder.fsub(x, builder.fsub(total, part))
    return total, builder.fadd(one, builder.fsub(y, part))


@intrinsic
def place_nodes(typingctx, clock, number, h, b, nodes):
    """The offsets from the step's centre and the weights of the nodes, on a reference orbit.

    clock   (3,)     revolutions a step, eccentricity e, and the mean anomaly at the start over 2 pi
    number  of the step since the problem's start, as a float
    b       (P,)     weights of the rule
    nodes   (5, P)   see galvi.kernels.lanes.frames.collocation

    With u the eccentric anomaly, n t = u - e sin u from one end of the step to the other; these
    ends are taken at u = M + e sin M (1 + e cos M), which differs from Kepler's by e^3, since any
    smooth map will do. Times are scaled so that the step's length is h, and weights so that they
    integrate a constant exactly.
    """
    real = types.float64
    signature = types.void(clock, real, real, b, nodes)

    def generate(context, builder, signature, values):
        numbers, rule, rows = _arrays(context, builder, signature, values, (0, 3, 4))
        padded = builder.extract_value(rows.shape, 1)
        row = padded.type
        lanes = Lanes(context, builder, padded, row(0))

        def known(k):
            return Lane(builder, lanes.spread(lanes.number(numbers.data, row(k))))

        turns, e, phase = known(TURNS), known(ECCENTRICITY), known(PHASE)
        h = Lane(builder, lanes.spread(values[2]))
        ends = ir.Constant(NOTHING.type, [0.0] + [1.0] * (LANES - 1))
        count = Lane(builder, lanes.spread(values[1])).exact
        whole = (turns * count + phase).exact
        fraction = (whole - whole.call("floor")).fused + turns * Lane(builder, ends)
        mean = fraction * TWO_PI
        sine, cosine = sine_cosine(mean)
        u = mean + e * sine * (1.0 + e * cosine)
        time = u - e * sine_cosine(u)[0]
        half = ir.IntType(32)

        def at(lane, k):
            return Lane(builder, lanes.spread(builder.extract_element(lane.value, half(k))))

        u_0, t_0 = at(u, 0), at(time, 0)
        length, span = at(u, 1) - u_0, at(time, 1) - t_0
        middle, scale = u_0 + length * 0.5, h / span
        total = cgutils.alloca_once_value(builder, NOTHING)
        chunks = builder.udiv(padded, row(LANES))
        with cgutils.for_range(builder, chunks, intp=row) as loop:
            part = Lanes(context, builder, padded, loop.index)

            def load(k, part=part):
                return Lane(builder, part.load(rows.data, row(k)))

            here = middle + length * 0.5 * load(PLACE)
            sine, cosine = sine_cosine(here)
            offset = (here - e * sine - t_0) * scale - h * 0.5
            weight = scale * length * load(PACE) * (1.0 - e * cosine)
            part.store(offset.value, rows.data, row(OFFSET))
            part.store(weight.value, rows.data, row(WEIGHT))
            share = Lane(builder, part.load(rule.data, row(0))) * weight
            builder.store((Lane(builder, builder.load(total)) + share).value, total)
        summed = Lane(builder, lanes.spread(added_up(builder, builder.load(total))))
        right = h / summed
        with cgutils.for_range(builder, chunks, intp=row) as loop:
            part = Lanes(context, builder, padded, loop.index)
            weight = Lane(builder, part.load(rows.data, row(WEIGHT)))
            part.store((weight * right).value, rows.data, row(WEIGHT))
        return context.get_dummy_value()

    return signature, generate
