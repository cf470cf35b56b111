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

UNROLLED_TERMS = 8  # terms of a sum without a loop
BLOCK_ROWS = 12, 4, 1  # numbers of rows that are updated at once: their sums run in parallel
TIME, OFFSET, WEIGHT, POSITION, SLOPE = range(5)  # rows of nodes
REVOLUTIONS, ECCENTRICITY, PHASE = range(3)  # numbers of a clock, see `place_nodes`
# Pairs of shuffles of two vectors; three rounds sum the lanes of eight vectors.
SHUFFLES = (
    ([0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]),
    ([0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]),
    ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]),
)


def _arrays(context, builder, signature, values, indices):
    return [context.make_array(signature.args[k])(context, builder, values[k]) for k in indices]


class RowUpdate:
    """The code of W <- the state + the sums of k by the rows of the matrix, see `place_rows`.

    The arrays are numba's; ``largest`` points to the bits of the largest change at each lane.
    """

    def __init__(self, context, builder, table, slopes, out, scales):
        self.builder, self.table, self.out, self.scales = builder, table, out, scales
        self.slopes, self.row = slopes, builder.extract_value(out.shape, 1).type
        self.of_k = Lanes(context, builder, builder.extract_value(slopes.shape, 1), self.row(0))
        self.stages = builder.extract_value(table.shape, 0)
        self.eights = builder.udiv(self.stages, self.row(UNROLLED_TERMS))
        self.largest = cgutils.alloca_once(builder, BITS)
        builder.store(ir.Constant(BITS, [0] * LANES), self.largest)

    def update(self, lanes, first, origin, offset, count, measured):
        """Update the rows of W for ``count`` numbers of ``origin``, from ``first`` on, in eight
        stages; ``offset`` is the row of W for the first number of ``origin``."""
        builder, row = self.builder, self.row
        r = builder.add(first, offset)
        sums = [
            lanes.variable(lanes.spread(lanes.number(origin, lanes.plus(first, i))))
            for i in range(count)
        ]
        unrolled = builder.mul(self.eights, row(UNROLLED_TERMS))
        with cgutils.for_range(builder, self.eights, intp=row) as loop:
            self._add(lanes, r, sums, builder.mul(loop.index, row(UNROLLED_TERMS)), UNROLLED_TERMS)
        with cgutils.for_range(builder, builder.sub(self.stages, unrolled), intp=row) as loop:
            self._add(lanes, r, sums, builder.add(unrolled, loop.index), 1)
        totals = [builder.load(pointer) for pointer in sums]
        for i, moved in enumerate(totals):
            target_row = lanes.plus(r, i)
            if measured:
                self._measure(lanes, target_row, moved)
            lanes.store(moved, self.out.data, target_row)

    def _add(self, lanes, r, sums, stage, count):
        """Add the products with ``count`` stages, from ``stage`` on, to the sums of rows from r
        on."""
        builder = self.builder
        totals = [builder.load(pointer) for pointer in sums]
        for j in range(count):
            column = builder.add(stage, self.row(j))
            factor = lanes.load(self.table.data, column)
            for i in range(len(sums)):
                value = self.of_k.number(self.slopes.data, lanes.plus(r, i), column)
                totals[i] = lanes.add(totals[i], lanes.mul(lanes.spread(value), factor))
        for total, pointer in zip(totals, sums, strict=True):
            builder.store(total, pointer)

    def _measure(self, lanes, target_row, moved):
        builder = self.builder
        scale = lanes.spread(lanes.number(self.scales.data, target_row))
        change = Lane(builder, builder.fsub(moved, lanes.load(self.out.data, target_row)))
        bits = abs(change * Lane(builder, scale)).bits
        before = builder.load(self.largest)
        # Bit patterns of nonnegative numbers are ordered like these, with NaN last.
        exceeds = builder.icmp_signed(">", bits, before)
        builder.store(builder.select(exceeds, bits, before), self.largest)


@intrinsic
def place_rows(typingctx, matrix, k, q, v, W, sizes, measure):
    """W <- the state + the sums of k by the rows of the matrix; returns the largest change of W.

    Parameters
    ----------
    matrix : array, shape (s, P)
        A^T of the collocation
    k, W : array, shape (2 n, P)
        slopes and states at the stages: n rows of positions, n of velocities; P of k may differ
    q, v : array, shape (n or more,)
        the state
    sizes : array, shape (2 n,)
        inverse sizes of the rows, to which changes are relative; NaN counts as the largest change
    measure
        whether the change is measured; if not, 0 is returned
    """
    signature = types.float64(matrix, k, q, v, W, sizes, types.boolean)

    def generate(context, builder, signature, values):
        table, slopes, positions, velocities, out, scales = _arrays(
            context, builder, signature, values, range(6)
        )
        row_update = RowUpdate(context, builder, table, slopes, out, scales)
        padded, row = builder.extract_value(out.shape, 1), row_update.row
        rows = builder.udiv(builder.extract_value(out.shape, 0), row(2))

        def all_rows(measured):
            chunks = builder.udiv(padded, row(LANES))
            with cgutils.for_range(builder, chunks, intp=row) as outer:
                lanes = Lanes(context, builder, padded, outer.index)
                for half, origin in enumerate((positions.data, velocities.data)):
                    offset = builder.mul(rows, row(half))
                    next_row = row(0)
                    for size in BLOCK_ROWS:
                        blocks = builder.udiv(builder.sub(rows, next_row), row(size))
                        with cgutils.for_range(builder, blocks, intp=row) as loop:
                            first = builder.add(next_row, builder.mul(loop.index, row(size)))
                            row_update.update(lanes, first, origin, offset, size, measured)
                        next_row = builder.add(next_row, builder.mul(blocks, row(size)))

        with builder.if_else(values[6]) as (measuring, only_updating):
            with measuring:
                all_rows(True)
            with only_updating:
                all_rows(False)
        lanes = Lanes(context, builder, padded, row(0))
        return builder.bitcast(lanes.largest(builder.load(row_update.largest)), DOUBLE)

    return signature, generate


@intrinsic
def interpolate_rows(typingctx, matrix, source, target):
    """target <- source times the matrix.

    Parameters
    ----------
    matrix : array, shape (s, P)
        values of the interpolation polynomials of the s nodes of ``source`` at those of ``target``
    source, target : array, shape (rows, P)
        values at the nodes; P may differ
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
                row_index = loop.index
                total = lanes.variable(ZEROS)
                with cgutils.for_range(builder, stages, intp=row) as inner:
                    value = lanes.spread(of_source.number(source_rows.data, row_index, inner.index))
                    term = lanes.mul(value, lanes.load(table.data, inner.index))
                    builder.store(lanes.add(builder.load(total), term), total)
                lanes.store(builder.load(total), out.data, row_index)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def spread_rows(typingctx, q, v, W):
    """W <- the state in all lanes; arrays as for `place_rows`."""
    signature = types.void(q, v, W)

    def generate(context, builder, signature, values):
        positions, velocities, out = _arrays(context, builder, signature, values, range(3))
        padded = builder.extract_value(out.shape, 1)
        row = padded.type
        rows = builder.udiv(builder.extract_value(out.shape, 0), row(2))
        with cgutils.for_range(builder, builder.udiv(padded, row(LANES)), intp=row) as outer:
            lanes = Lanes(context, builder, padded, outer.index)
            for half, origin in enumerate((positions.data, velocities.data)):
                offset = builder.mul(rows, row(half))
                with cgutils.for_range(builder, rows, intp=row) as loop:
                    value = lanes.spread(lanes.number(origin, loop.index))
                    lanes.store(value, out.data, builder.add(offset, loop.index))
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def add_rows(typingctx, b, k, high, low, first, rows):
    """Add sum_j b_j k_j to high + low, compensated, for ``rows`` rows of k from ``first`` on.

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
            pointers = [
                builder.bitcast(builder.gep(array.data, [begin]), ZEROS.type.as_pointer())
                for array in (highs, lows)
            ]
            state = [builder.load(pointer) for pointer in pointers]
            for value in state:
                value.align = 8
            moved = compensated(
                *(Lane(builder, value, ()) for value in state),
                Lane(builder, sums_of_eight(builder, row_sums), ()),
            )
            for value, pointer in zip(moved, pointers, strict=True):
                builder.store(value.value, pointer).align = 8
        tail_start = builder.mul(eights, row(LANES))
        with cgutils.for_range(builder, builder.sub(rows, tail_start), intp=row) as loop:
            row_index = builder.add(tail_start, loop.index)
            total = sum_of_lanes(builder, products(builder.add(row_index, first)))
            pointers = [builder.gep(array.data, [row_index]) for array in (highs, lows)]
            high, low = (Lane(builder, builder.load(pointer), ()) for pointer in pointers)
            moved = compensated(high, low, Lane(builder, total, ()))
            for value, pointer in zip(moved, pointers, strict=True):
                builder.store(value.value, pointer)
        return context.get_dummy_value()

    return signature, generate


def sums_of_eight(builder, vectors):
    """A vector whose lanes are the sums of the lanes of eight vectors."""
    kind = ir.VectorType(ir.IntType(32), LANES)
    for shuffles in SHUFFLES:
        vectors = [
            builder.fadd(
                *(builder.shuffle_vector(a, b, ir.Constant(kind, indices)) for indices in shuffles)
            )
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
    return vectors[0]


def sum_of_lanes(builder, vector):
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
    """Set the times since the step's centre and the weights of the nodes, on a reference orbit.

    Parameters
    ----------
    clock : array, shape (3,)
        revolutions in a step, eccentricity e, and the mean anomaly at the problem's start over 2 pi
    number
        number of steps since the problem's start, a float
    h
        length of the step
    b : array, shape (P,)
        weights of the rule
    nodes : array, shape (5, P)
        see galvi.lanes.frames.collocation

    Notes
    -----
    With u the eccentric anomaly, n t = u - e sin u from one end of the step to the other. The ends
    are taken at u = M + e sin M (1 + e cos M), which differs from the solution of Kepler's equation
    by O(e^3): any smooth map is admissible. Times are scaled so that the step's length is h, and
    weights so that they integrate a constant exactly.
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

        revolutions_per_step, e, phase = (
            clock_number(REVOLUTIONS),
            clock_number(ECCENTRICITY),
            clock_number(PHASE),
        )
        h = Lane(builder, lanes.spread(values[2]))
        ends = ir.Constant(ZEROS.type, [0.0] + [1.0] * (LANES - 1))
        count = Lane(builder, lanes.spread(values[1])).exact
        revolutions = (revolutions_per_step * count + phase).exact
        fraction = (revolutions - revolutions.call("floor")).fused + revolutions_per_step * Lane(
            builder, ends
        )
        mean = fraction * TWO_PI
        sine, cosine = sine_cosine(mean)
        u = mean + e * sine * (1.0 + e * cosine)
        time = u - e * sine_cosine(u)[0]
        int32 = ir.IntType(32)

        def at(lane, k):
            return Lane(builder, lanes.spread(builder.extract_element(lane.value, int32(k))))

        u_0, t_0 = at(u, 0), at(time, 0)
        length, span = at(u, 1) - u_0, at(time, 1) - t_0
        middle, scale = u_0 + length * 0.5, h / span
        total = cgutils.alloca_once_value(builder, ZEROS)
        chunks = builder.udiv(padded, row(LANES))
        with cgutils.for_range(builder, chunks, intp=row) as loop:
            part = Lanes(context, builder, padded, loop.index)

            def load(k, part=part):
                return Lane(builder, part.load(rows.data, row(k)))

            node_u = middle + length * 0.5 * load(POSITION)
            sine, cosine = sine_cosine(node_u)
            offset = (node_u - e * sine - t_0) * scale - h * 0.5
            weight = scale * length * load(SLOPE) * (1.0 - e * cosine)
            part.store(offset.value, rows.data, row(OFFSET))
            part.store(weight.value, rows.data, row(WEIGHT))
            term = Lane(builder, part.load(rule.data, row(0))) * weight
            builder.store((Lane(builder, builder.load(total)) + term).value, total)
        weight_sum = Lane(builder, lanes.spread(sum_of_lanes(builder, builder.load(total))))
        factor = h / weight_sum
        with cgutils.for_range(builder, chunks, intp=row) as loop:
            part = Lanes(context, builder, padded, loop.index)
            weight = Lane(builder, part.load(rows.data, row(WEIGHT)))
            part.store((weight * factor).value, rows.data, row(WEIGHT))
        return context.get_dummy_value()

    return signature, generate
