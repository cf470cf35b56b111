"""Vector instructions over the stages of a step of point masses, eight at a time.

numba does not vectorise loops whose arrays may overlap; these functions use LLVM's vector types
instead. In an array (rows, P) the lanes after the last stage repeat the last stage.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.vectors import BITS, DOUBLE, LANES, ZEROS, Lanes

__all__ = [
    "LANES",
    "add_combined",
    "attract",
    "attract_and_measure",
    "attract_pair",
    "combine",
    "drift",
    "follow",
    "follow_and_measure",
    "fused",
    "move",
]


def _attraction_intrinsics(massless):
    """Two intrinsics for the attraction of a body in eight stages; the second measures distances.

    With a mass, i = heavy[k] and the bodies j before it in ``heavy``, the last one first, attract
    each other: a_i += Gm_j g, a_j -= Gm_i g, g = (q_j - q_i) / |q_j - q_i|^3; rows are the axes of
    each body. For the last k the accelerations of all these bodies start from zero. If
    ``massless``, i = k, and a_i is set to the attraction by all bodies in ``heavy``. The second
    intrinsic lowers nearest (P,) to the smallest squared distance at each stage.
    """
    integer = types.intp

    @intrinsic
    def attract_only(typingctx, axes, Q, a, masses, heavy, k, padded, chunk):
        signature = types.void(axes, Q, a, masses, heavy, integer, integer, integer)

        def generate(context, builder, signature, arguments):
            _generate_attraction(context, builder, signature, arguments, None, massless)
            return context.get_dummy_value()

        return signature, generate

    @intrinsic
    def attract_and_measure_distances(
        typingctx, axes, Q, a, masses, heavy, k, padded, chunk, nearest
    ):
        signature = types.void(axes, Q, a, masses, heavy, integer, integer, integer, nearest)

        def generate(context, builder, signature, arguments):
            _generate_attraction(context, builder, signature, arguments[:8], arguments[8], massless)
            return context.get_dummy_value()

        return signature, generate

    return attract_only, attract_and_measure_distances


def _generate_attraction(context, builder, signature, arguments, nearest, massless):
    """Generate the code of `_attraction_intrinsics`; ``nearest`` is None to measure no
    distances."""
    entry, padded, chunk = arguments[5:]
    lanes = Lanes(context, builder, padded, chunk)
    dimension = signature.args[0].count
    places, pulls, weights, bodies = (
        lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 2, 3, 4)
    )
    count = context.make_array(signature.args[4])(context, builder, arguments[4]).nitems
    unit, step = ir.Constant(entry.type, 1), ir.Constant(entry.type, dimension)
    is_last = builder.icmp_signed("==", builder.add(entry, unit), count)

    def accumulated(row):
        return ZEROS if massless else builder.select(is_last, ZEROS, lanes.load(pulls, row))

    i = entry if massless else lanes.number(bodies, entry)
    row_i = builder.mul(i, step)
    q_i = [lanes.load(places, lanes.plus(row_i, x)) for x in range(dimension)]
    mass_i = lanes.spread(lanes.number(weights, i))
    pulled = [lanes.variable(accumulated(lanes.plus(row_i, x))) for x in range(dimension)]
    nearest_square, zero = None, ir.Constant(i.type, 0)
    if nearest is not None:
        squares = lanes.pointer_to(signature.args[8], nearest)
        nearest_square = lanes.variable(lanes.load(squares, zero))
    partners = count if massless else entry
    with cgutils.for_range(builder, partners) as loop:
        last_first = builder.sub(builder.sub(partners, unit), loop.index)
        j = lanes.number(bodies, last_first)
        row_j = builder.mul(j, step)
        gaps, square, pull = lanes.pull(places, q_i, row_j)
        if nearest_square is not None:
            before = builder.load(nearest_square)
            smaller = builder.fcmp_ordered("<", square, before)
            builder.store(builder.select(smaller, square, before), nearest_square)
        onto_i = lanes.mul(lanes.spread(lanes.number(weights, j)), pull)
        onto_j = lanes.mul(mass_i, pull)
        for x, gap in enumerate(gaps):
            row = lanes.plus(row_j, x)
            if not massless:
                lanes.store(lanes.sub(accumulated(row), lanes.mul(onto_j, gap)), pulls, row)
            total = lanes.add(builder.load(pulled[x]), lanes.mul(onto_i, gap))
            builder.store(total, pulled[x])
    for x in range(dimension):
        lanes.store(builder.load(pulled[x]), pulls, lanes.plus(row_i, x))
    if nearest_square is not None:
        lanes.store(builder.load(nearest_square), squares, zero)


attract, attract_and_measure = _attraction_intrinsics(massless=False)
follow, follow_and_measure = _attraction_intrinsics(massless=True)


@intrinsic
def attract_pair(typingctx, axes, Q, initial, a, i, j, mass_i, mass_j, padded, chunk):
    """a_i <- initial_i + mass_j g, a_j <- initial_j - mass_i g for one pair, g as for
    ``attract``."""
    integer, real = types.intp, types.float64
    signature = types.void(axes, Q, initial, a, integer, integer, real, real, integer, integer)

    def generate(context, builder, signature, arguments):
        i, j, mass_i, mass_j, padded, chunk = arguments[4:]
        lanes = Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        places, initial_rows, pulls = (
            lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 2, 3)
        )
        row_i, row_j = (builder.mul(body, ir.Constant(i.type, dimension)) for body in (i, j))
        q_i = [lanes.load(places, lanes.plus(row_i, x)) for x in range(dimension)]
        gaps, _square, pull = lanes.pull(places, q_i, row_j)
        onto_i, onto_j = (
            lanes.mul(lanes.spread(mass_j), pull),
            lanes.mul(lanes.spread(mass_i), pull),
        )
        for x, gap in enumerate(gaps):
            i_row, j_row = lanes.plus(row_i, x), lanes.plus(row_j, x)
            lanes.store(
                lanes.add(lanes.load(initial_rows, i_row), lanes.mul(onto_i, gap)), pulls, i_row
            )
            lanes.store(
                lanes.sub(lanes.load(initial_rows, j_row), lanes.mul(onto_j, gap)), pulls, j_row
            )
        return context.get_dummy_value()

    return signature, generate


def _combine_intrinsic(adds=False):
    """An intrinsic: out <- sum_j a_j matrix[start + j] for the axes of a body, in eight stages.

    Parameters
    ----------
    onto
        whether the sum is added to ``out``
    """
    integer = types.intp

    @intrinsic
    def combine_rows(typingctx, axes, matrix, start, a, out, body, stages, padded, chunk):
        signature = types.void(axes, matrix, integer, a, out, integer, integer, integer, integer)

        def generate(context, builder, signature, arguments):
            start, body, stages, padded, chunk = (arguments[k] for k in (2, 5, 6, 7, 8))
            lanes = Lanes(context, builder, padded, chunk)
            dimension = signature.args[0].count
            factors, values, targets = (
                lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 3, 4)
            )
            row = builder.mul(body, ir.Constant(body.type, dimension))
            first = [lanes.zero] * dimension
            if adds:
                first = [lanes.load(targets, lanes.plus(row, x)) for x in range(dimension)]
            sums = lanes.sums(first, factors, start, values, row, stages)
            for x, total in enumerate(sums):
                lanes.store(total, targets, lanes.plus(row, x))
            return context.get_dummy_value()

        return signature, generate

    return combine_rows


combine, add_combined = _combine_intrinsic(), _combine_intrinsic(adds=True)


@intrinsic
def move(typingctx, axes, matrix, start, a, base, low, q, Q, change, size, body, stages, chunk):
    """Q <- q + (base + (low + sum_j a_j matrix[start + j])) for the axes of a body, in eight
    stages.

    Returns the larger of ``change`` and ``size`` times the largest |change of Q|; NaN counts as
    largest.
    """
    integer, real = types.intp, types.float64
    signature = real(
        axes, matrix, integer, a, base, low, q, Q, real, real, integer, integer, integer
    )

    def generate(context, builder, signature, arguments):
        start, change, size, body, stages, chunk = (arguments[k] for k in (2, *range(8, 13)))
        stage_array = context.make_array(signature.args[7])(context, builder, arguments[7])
        padded = builder.extract_value(stage_array.shape, 1)
        lanes = Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        factors, values, bases, lows, origin, places = (
            lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 3, 4, 5, 6, 7)
        )
        row = builder.mul(body, ir.Constant(body.type, dimension))
        low_parts = [lanes.load(lows, lanes.plus(row, x)) for x in range(dimension)]
        sums = lanes.sums(low_parts, factors, start, values, row, stages)
        scale = lanes.spread(size)
        largest = builder.bitcast(lanes.spread(change), BITS)
        for x, total in enumerate(sums):
            axis_row = lanes.plus(row, x)
            step = builder.fadd(lanes.load(bases, axis_row), total)
            moved = builder.fadd(lanes.spread(lanes.number(origin, axis_row)), step)
            scaled_change = lanes.mul(builder.fsub(moved, lanes.load(places, axis_row)), scale)
            # The bit patterns of nonnegative numbers are ordered like the numbers, with NaN last.
            bits = builder.bitcast(lanes.call("fabs", scaled_change), BITS)
            largest = builder.select(builder.icmp_signed(">", bits, largest), bits, largest)
            lanes.store(moved, places, axis_row)
        return builder.bitcast(lanes.largest(largest), DOUBLE)

    return signature, generate


@intrinsic
def drift(typingctx, c, base, low, row, displacement, displacement_low, q_low, padded, chunk):
    """base <- c displacement, and low <- its rounding error plus all low parts, for one row, in
    eight stages.

    Parameters
    ----------
    c : array, shape (2, P)
        nodes and their low parts
    displacement, displacement_low
        h v and its low part
    q_low
        low part of q
    """
    integer, real = types.intp, types.float64
    signature = types.void(c, base, low, integer, real, real, real, integer, integer)

    def generate(context, builder, signature, arguments):
        row, displacement, displacement_low, q_low, padded, chunk = arguments[3:]
        lanes = Lanes(context, builder, padded, chunk)
        nodes, bases, lows = (lanes.pointer_to(signature.args[k], arguments[k]) for k in range(3))
        zero = ir.Constant(row.type, 0)
        node, node_low = lanes.load(nodes, zero), lanes.load(nodes, lanes.plus(zero, 1))
        displacement, displacement_low, q_low = (
            lanes.spread(displacement),
            lanes.spread(displacement_low),
            lanes.spread(q_low),
        )
        path = builder.fmul(node, displacement)
        error = lanes.call("fma", node, displacement, builder.fneg(path))
        low_part = lanes.add(lanes.mul(node_low, displacement), lanes.mul(node, displacement_low))
        low_part = lanes.add(lanes.add(error, q_low), low_part)
        lanes.store(path, bases, row)
        lanes.store(low_part, lows, row)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def fused(typingctx, x, y, z):
    """x y + z, rounded once."""
    signature = types.float64(types.float64, types.float64, types.float64)

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return signature, generate
