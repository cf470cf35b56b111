"""Vector instructions of `galvi.lanes.frames.collocation` on its rows of stages."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.constants import TWO_PI
from galvi.lanes.functions import sine_cosine, two_sum
from galvi.lanes.values import Lane
from galvi.lanes.vectors import BITS, DOUBLE, LANES, ZEROS, Lanes

UNROLLED = 8  # terms of a sum that are written out
BLOCKS = 12, 4, 1  # rows that are done together: chains of sums that run in parallel
TIME, OFFSET, WEIGHT, PLACE, PACE = range(5)  # rows of nodes
TURNS, ECCENTRICITY, PHASE = range(3)  # of a clock


def _arrays(context, builder, signature, values, which):
    return [context.make_array(signature.args[k])(context, builder, values[k]) for k in which]


class MovedRows:
    """Generates W <- the state + the sums of k by the rows of the matrix: see `place_rows`.

    The arrays are numba's; ``largest`` points to the bits of the largest change.
    """

    def __init__(self, context, builder, table, slopes, out, scales):
        self.builder, self.table, self.out, self.scales = builder, table, out, scales
        self.slopes, self.row = slopes, builder.extract_value(out.shape, 1).type
        self.of_k = Lanes(context, builder, builder.extract_value(slopes.shape, 1), self.row(0))
        self.stages = builder.extract_value(table.shape, 0)
        self.eights = builder.udiv(self.stages, self.row(UNROLLED))
        self.largest = cgutils.alloca_once(builder, BITS)
        builder.store(ir.Constant(BITS, [0] * LANES), self.largest)

    def do(self, lanes, first, origin, offset, count, measured):
        """``count`` rows of the state in ``origin`` from ``first`` on, in eight stages."""
        builder, row = self.builder, self.row
        r = builder.add(first, offset)
        sums = [
            lanes.variable(lanes.spread(lanes.number(origin, lanes.plus(first, i))))
            for i in range(count)
        ]
        written = builder.mul(self.eights, row(UNROLLED))
        with cgutils.for_range(builder, self.eights, intp=row) as loop:
            self._add(lanes, r, sums, builder.mul(loop.index, row(UNROLLED)), UNROLLED)
        with cgutils.for_range(builder, builder.sub(self.stages, written), intp=row) as loop:
            self._add(lanes, r, sums, builder.add(written, loop.index), 1)
        totals = [builder.load(pointer) for pointer in sums]
        for i, moved in enumerate(totals):
            this = lanes.plus(r, i)
            if measured:
                self._measure(lanes, this, moved)
            lanes.store(moved, self.out.data, this)

    def _add(self, lanes, r, sums, stage, many):
        """Add the products of ``many`` stages to the sums of rows from r on."""
        builder = self.builder
        totals = [builder.load(pointer) for pointer in sums]
        for j in range(many):
            column = builder.add(stage, self.row(j))
            factor = lanes.load(self.table.data, column)
            for i in range(len(sums)):
                value = self.of_k.number(self.slopes.data, lanes.plus(r, i), column)
                totals[i] = lanes.add(totals[i], lanes.mul(lanes.spread(value), factor))
        for total, pointer in zip(totals, sums, strict=True):
            builder.store(total, pointer)

    def _measure(self, lanes, this, moved):
        builder = self.builder
        scale = lanes.spread(lanes.number(self.scales.data, this))
        change = Lane(builder, builder.fsub(moved, lanes.load(self.out.data, this)))
        bits = abs(change * Lane(builder, scale)).bits
        before = builder.load(self.largest)
        # Bit patterns of nonnegative numbers are ordered like these, with NaN last.
        exceeds = builder.icmp_signed(">", bits, before)
        builder.store(builder.select(exceeds, bits, before), self.largest)


@intrinsic
def place_rows(typingctx, matrix, k, q, v, W, sizes, measure):
    """W <- the state + the sums of k by the rows of the matrix; returns the largest change.

    Parameters
    ----------
    matrix : array, shape (s, P)
        A^T of the collocation
    k, W : array, shape (2 n, P)
        slopes and states at the stages: n rows of places, n of velocities; k may have another P
    q, v : array, shape (n or more,)
        the state
    sizes : array, shape (2 n,)
        1 / sizes of the rows; the change is relative to them, NaN the largest
    measure
        whether the change is measured; else 0 is returned
    """
    signature = types.float64(matrix, k, q, v, W, sizes, types.boolean)

    def generate(context, builder, signature, values):
        table, slopes, places, speeds, out, scales = _arrays(
            context, builder, signature, values, range(6)
        )
        moved = MovedRows(context, builder, table, slopes, out, scales)
        padded, row = builder.extract_value(out.shape, 1), moved.row
        rows = builder.udiv(builder.extract_value(out.shape, 0), row(2))

        def all_rows(measured):
            chunks = builder.udiv(padded, row(LANES))
            with cgutils.for_range(builder, chunks, intp=row) as outer:
                lanes = Lanes(context, builder, padded, outer.index)
                for half, origin in enumerate((places.data, speeds.data)):
                    offset = builder.mul(rows, row(half))
                    next_row = row(0)
                    for size in BLOCKS:
                        blocks = builder.udiv(builder.sub(rows, next_row), row(size))
                        with cgutils.for_range(builder, blocks, intp=row) as loop:
                            first = builder.add(next_row, builder.mul(loop.index, row(size)))
                            moved.do(lanes, first, origin, offset, size, measured)
                        next_row = builder.add(next_row, builder.mul(blocks, row(size)))

        with builder.if_else(values[6]) as (yes, no):
            with yes:
                all_rows(True)
            with no:
                all_rows(False)
        lanes = Lanes(context, builder, padded, row(0))
        return builder.bitcast(lanes.largest(builder.load(moved.largest)), DOUBLE)

    return signature, generate


@intrinsic
def interpolate_rows(typingctx, matrix, source, target):
    """The target's rows <- those of the source times the matrix.

    Parameters
    ----------
    matrix : array, shape (s, P)
        values of the polynomials of the source's nodes
    source, target : array, shape (rows, P)
        each
    """
    signature = types.void(matrix, source, target)

    def generate(context, builder, signature, values):
        table, source_rows, out = _arrays(context, builder, signature, values, range(3))
        count = builder.extract_value(out.shape, 0)
        padded = builder.extract_value(out.shape, 1)
        row = padded.type
        stages = builder.extract_value(table.shape, 0)
        of_source = Lanes(context, builder, builder.extract_value(source_rows.shape, 1), row(0))
        with cgutils.for_range(builder, builder.udiv(padded, row(LANES)), intp=row) as outer:
            lanes = Lanes(context, builder, padded, outer.index)
            with cgutils.for_range(builder, count, intp=row) as loop:
                this = loop.index
                total = lanes.variable(ZEROS)
                with cgutils.for_range(builder, stages, intp=row) as inner:
                    value = lanes.spread(of_source.number(source_rows.data, this, inner.index))
                    term = lanes.mul(value, lanes.load(table.data, inner.index))
                    builder.store(lanes.add(builder.load(total), term), total)
                lanes.store(builder.load(total), out.data, this)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def spread_rows(typingctx, q, v, W):
    """W <- the state in all lanes; arrays as for `place_rows`."""
    signature = types.void(q, v, W)

    def generate(context, builder, signature, values):
        places, speeds, out = _arrays(context, builder, signature, values, range(3))
        padded = builder.extract_value(out.shape, 1)
        row = padded.type
        rows = builder.udiv(builder.extract_value(out.shape, 0), row(2))
        with cgutils.for_range(builder, builder.udiv(padded, row(LANES)), intp=row) as outer:
            lanes = Lanes(context, builder, padded, outer.index)
            for half, origin in enumerate((places.data, speeds.data)):
                offset = builder.mul(rows, row(half))
                with cgutils.for_range(builder, rows, intp=row) as loop:
                    value = lanes.spread(lanes.number(origin, loop.index))
                    lanes.store(value, out.data, builder.add(offset, loop.index))
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def add_rows(typingctx, b, k, high, low, first, rows):
    """high + low <- high + low + sum_j b_j k_j, compensated, for ``rows`` rows of k from ``first``.

    Parameters
    ----------
    b : array, shape (P,)
        weights, 0 in the lanes after the last stage
    k : array, shape (2 n, P)
        slopes at the stages
    high, low : array, shape (n or more,)
    """
    integer = types.intp
    signature = types.void(b, k, high, low, integer, integer)

    def generate(context, builder, signature, values):
        weights, slopes, highs, lows = _arrays(context, builder, signature, values, range(4))
        padded = builder.extract_value(slopes.shape, 1)
        row = padded.type
        first, rows = values[4:]
        chunks = builder.udiv(padded, row(LANES))

        def products(r):
            """Lanes whose sum is sum_j b_j k_j of a row."""
            total = cgutils.alloca_once(builder, ZEROS.type)
            builder.store(ZEROS, total)
            with cgutils.for_range(builder, chunks, intp=row) as inner:
                lanes = Lanes(context, builder, padded, inner.index)
                weight = Lane(builder, lanes.load(weights.data, row(0)))
                product = weight * Lane(builder, lanes.load(slopes.data, r))
                builder.store((product + Lane(builder, builder.load(total))).value, total)
            return builder.load(total)

        def compensated(high, low, increment):
            high, error = two_sum(high, increment)
            return two_sum(high, error + low)

        eights = builder.udiv(rows, row(LANES))
        with cgutils.for_range(builder, eights, intp=row) as loop:
            begin = builder.mul(loop.index, row(LANES))
            r = builder.add(begin, first)
            row_sums = [products(builder.add(r, row(i))) for i in range(LANES)]
            places = [
                builder.bitcast(builder.gep(array.data, [begin]), ZEROS.type.as_pointer())
                for array in (highs, lows)
            ]
            state = [builder.load(pointer) for pointer in places]
            for value in state:
                value.align = 8
            moved = compensated(
                *(Lane(builder, value, ()) for value in state),
                Lane(builder, sums_of_eight(builder, row_sums), ()),
            )
            for value, pointer in zip(moved, places, strict=True):
                builder.store(value.value, pointer).align = 8
        tail_start = builder.mul(eights, row(LANES))
        with cgutils.for_range(builder, builder.sub(rows, tail_start), intp=row) as loop:
            this = builder.add(tail_start, loop.index)
            total = added_up(builder, products(builder.add(this, first)))
            places = [builder.gep(array.data, [this]) for array in (highs, lows)]
            high, low = (Lane(builder, builder.load(pointer), ()) for pointer in places)
            moved = compensated(high, low, Lane(builder, total, ()))
            for value, pointer in zip(moved, places, strict=True):
                builder.store(value.value, pointer)
        return context.get_dummy_value()

    return signature, generate


PAIRS = (
    ([0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]),
    ([0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]),
    ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]),
)


def sums_of_eight(builder, vectors):
    """The sums of eight vectors' lanes, as the lanes of one."""
    kind = ir.VectorType(ir.IntType(32), LANES)
    for pairs in PAIRS:
        vectors = [
            builder.fadd(
                *(builder.shuffle_vector(a, b, ir.Constant(kind, places)) for places in pairs)
            )
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
    return vectors[0]


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


@intrinsic
def place_nodes(typingctx, clock, number, h, b, nodes):
    """The offsets from the step's centre and the weights of the nodes, on a reference orbit.

    Parameters
    ----------
    clock : array, shape (3,)
        revolutions a step, eccentricity e, and the mean anomaly at the start over 2 pi
    number
        of the step since the problem's start, as a float
    b : array, shape (P,)
        weights of the rule
    nodes : array, shape (5, P)
        see galvi.lanes.frames.collocation

    Notes
    -----
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

        def clock_number(k):
            return Lane(builder, lanes.spread(lanes.number(numbers.data, row(k))))

        turns, e, phase = clock_number(TURNS), clock_number(ECCENTRICITY), clock_number(PHASE)
        h = Lane(builder, lanes.spread(values[2]))
        ends = ir.Constant(ZEROS.type, [0.0] + [1.0] * (LANES - 1))
        count = Lane(builder, lanes.spread(values[1])).exact
        revolutions = (turns * count + phase).exact
        fraction = (revolutions - revolutions.call("floor")).fused + turns * Lane(builder, ends)
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
        total = cgutils.alloca_once_value(builder, ZEROS)
        chunks = builder.udiv(padded, row(LANES))
        with cgutils.for_range(builder, chunks, intp=row) as loop:
            part = Lanes(context, builder, padded, loop.index)

            def load(k, part=part):
                return Lane(builder, part.load(rows.data, row(k)))

            node_u = middle + length * 0.5 * load(PLACE)
            sine, cosine = sine_cosine(node_u)
            offset = (node_u - e * sine - t_0) * scale - h * 0.5
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
