"""Vector instructions over the stages of a step, eight at a time.

numba does not vectorise loops whose arrays may overlap; these functions use LLVM's vector types
instead. In an array (rows, P) the lanes after the last stage repeat it.
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


def _attracting(massless):
    """Attraction in eight stages, and the same that measures distances.

    Between body i = heavy[k] and those before it in ``heavy``, the last j first: a_i += Gm_j g,
    a_j -= Gm_i g, g = (q_j - q_i) / |q_j - q_i|^3; rows are the axes of each body. For the last i,
    a of these bodies is initialised to zero. Of a ``massless`` body i = k: a_i <- its attraction by
    all in ``heavy``. nearest (P,) <- the smaller of it and each squared distance, by stages.
    """
    integer = types.intp

    @intrinsic
    def plain(typingctx, axes, Q, a, masses, heavy, k, padded, chunk):
        signature = types.void(axes, Q, a, masses, heavy, integer, integer, integer)

        def generate(context, builder, signature, arguments):
            _attraction(context, builder, signature, arguments, None, massless)
            return context.get_dummy_value()

        return signature, generate

    @intrinsic
    def measured(typingctx, axes, Q, a, masses, heavy, k, padded, chunk, nearest):
        signature = types.void(axes, Q, a, masses, heavy, integer, integer, integer, nearest)

        def generate(context, builder, signature, arguments):
            _attraction(context, builder, signature, arguments[:8], arguments[8], massless)
            return context.get_dummy_value()

        return signature, generate

    return plain, measured


def _attraction(context, builder, signature, arguments, nearest, massless):
    """The instructions of ``_attracting``; distances are measured if ``nearest`` is given."""
    entry, padded, chunk = arguments[5:]
    lanes = Lanes(context, builder, padded, chunk)
    dimension = signature.args[0].count
    places, pulls, weights, bodies = (
        lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 2, 3, 4)
    )
    count = context.make_array(signature.args[4])(context, builder, arguments[4]).nitems
    unit, step = ir.Constant(entry.type, 1), ir.Constant(entry.type, dimension)
    fresh = builder.icmp_signed("==", builder.add(entry, unit), count)

    def earlier(row):
        return ZEROS if massless else builder.select(fresh, ZEROS, lanes.load(pulls, row))

    i = entry if massless else lanes.number(bodies, entry)
    row_i = builder.mul(i, step)
    q_i = [lanes.load(places, lanes.plus(row_i, x)) for x in range(dimension)]
    mass_i = lanes.spread(lanes.number(weights, i))
    pulled = [lanes.variable(earlier(lanes.plus(row_i, x))) for x in range(dimension)]
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
                lanes.store(lanes.sub(earlier(row), lanes.mul(onto_j, gap)), pulls, row)
            total = lanes.add(builder.load(pulled[x]), lanes.mul(onto_i, gap))
            builder.store(total, pulled[x])
    for x in range(dimension):
        lanes.store(builder.load(pulled[x]), pulls, lanes.plus(row_i, x))
    if nearest_square is not None:
        lanes.store(builder.load(nearest_square), squares, zero)


attract, attract_and_measure = _attracting(massless=False)
follow, follow_and_measure = _attracting(massless=True)


@intrinsic
def attract_pair(typingctx, axes, Q, initial, a, i, j, mass_i, mass_j, padded, chunk):
    """a_i <- given_i + mass_j g, a_j <- given_j - mass_i g for one pair, as in ``attract``."""
    integer, real = types.intp, types.float64
    signature = types.void(axes, Q, initial, a, integer, integer, real, real, integer, integer)

    def generate(context, builder, signature, arguments):
        i, j, mass_i, mass_j, padded, chunk = arguments[4:]
        lanes = Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        places, before, pulls = (
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
            this, opposite = lanes.plus(row_i, x), lanes.plus(row_j, x)
            lanes.store(lanes.add(lanes.load(before, this), lanes.mul(onto_i, gap)), pulls, this)
            lanes.store(
                lanes.sub(lanes.load(before, opposite), lanes.mul(onto_j, gap)), pulls, opposite
            )
        return context.get_dummy_value()

    return signature, generate


def _combining(onto=False):
    """out <- sum_j a_j matrix[start + j] for all axes of one body, in one vector of stages.

    Parameters
    ----------
    onto
        whether the sum is added to what out holds
    """
    integer = types.intp

    @intrinsic
    def combined(typingctx, axes, matrix, start, a, out, body, stages, padded, chunk):
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
            if onto:
                first = [lanes.load(targets, lanes.plus(row, x)) for x in range(dimension)]
            sums = lanes.sums(first, factors, start, values, row, stages)
            for x, total in enumerate(sums):
                lanes.store(total, targets, lanes.plus(row, x))
            return context.get_dummy_value()

        return signature, generate

    return combined


combine, add_combined = _combining(), _combining(onto=True)


@intrinsic
def move(typingctx, axes, matrix, start, a, base, low, q, Q, change, size, body, stages, chunk):
    """Q <- q + (base + (low + sum_j a_j matrix[start + j])), all axes of one body, eight stages.

    Returns the larger of ``change`` and size |change of Q|; NaN counts as largest.
    """
    integer, real = types.intp, types.float64
    signature = real(
        axes, matrix, integer, a, base, low, q, Q, real, real, integer, integer, integer
    )

    def generate(context, builder, signature, arguments):
        start, change, size, body, stages, chunk = (arguments[k] for k in (2, *range(8, 13)))
        stages_of = context.make_array(signature.args[7])(context, builder, arguments[7])
        padded = builder.extract_value(stages_of.shape, 1)
        lanes = Lanes(context, builder, padded, chunk)
        dimension = signature.args[0].count
        factors, values, bases, lows, origin, places = (
            lanes.pointer_to(signature.args[k], arguments[k]) for k in (1, 3, 4, 5, 6, 7)
        )
        row = builder.mul(body, ir.Constant(body.type, dimension))
        small = [lanes.load(lows, lanes.plus(row, x)) for x in range(dimension)]
        sums = lanes.sums(small, factors, start, values, row, stages)
        scale = lanes.spread(size)
        largest = builder.bitcast(lanes.spread(change), BITS)
        for x, total in enumerate(sums):
            this = lanes.plus(row, x)
            step = builder.fadd(lanes.load(bases, this), total)
            moved = builder.fadd(lanes.spread(lanes.number(origin, this)), step)
            scaled_change = lanes.mul(builder.fsub(moved, lanes.load(places, this)), scale)
            # The bit patterns of nonnegative numbers are ordered like the numbers, with NaN last.
            bits = builder.bitcast(lanes.call("fabs", scaled_change), BITS)
            largest = builder.select(builder.icmp_signed(">", bits, largest), bits, largest)
            lanes.store(moved, places, this)
        return builder.bitcast(lanes.largest(largest), DOUBLE)

    return signature, generate


@intrinsic
def drift(typingctx, c, base, low, row, displacement, displacement_low, lost, padded, chunk):
    """base <- c far and low <- its rounding error and that of q, for one row, in eight stages.

    Parameters
    ----------
    c : array, shape (2, P)
        nodes and their low parts
    displacement
        h v, ``displacement_low`` its low part, ``lost`` the low part of q
    """
    integer, real = types.intp, types.float64
    signature = types.void(c, base, low, integer, real, real, real, integer, integer)

    def generate(context, builder, signature, arguments):
        row, displacement, displacement_low, lost, padded, chunk = arguments[3:]
        lanes = Lanes(context, builder, padded, chunk)
        nodes, bases, lows = (lanes.pointer_to(signature.args[k], arguments[k]) for k in range(3))
        zero = ir.Constant(row.type, 0)
        node, node_low = lanes.load(nodes, zero), lanes.load(nodes, lanes.plus(zero, 1))
        displacement, displacement_low, lost = (
            lanes.spread(displacement),
            lanes.spread(displacement_low),
            lanes.spread(lost),
        )
        path = builder.fmul(node, displacement)
        error = lanes.call("fma", node, displacement, builder.fneg(path))
        small = lanes.add(lanes.mul(node_low, displacement), lanes.mul(node, displacement_low))
        small = lanes.add(lanes.add(error, lost), small)
        lanes.store(path, bases, row)
        lanes.store(small, lows, row)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def fused(typingctx, x, y, z):
    """x y + z, rounded once."""
    signature = types.float64(types.float64, types.float64, types.float64)

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return signature, generate
