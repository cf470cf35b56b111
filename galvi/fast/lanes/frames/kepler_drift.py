"""Kepler's motions of all planets over a step, in vector instructions over the planets.

Numbers as in `galvi.fast.lanes.frames.kepler_motion`. In rows 4 to 7 of the state: D times n
entries, Q by coordinates, then D of the barycentre; likewise their low parts, the velocities and
theirs. Rows have at least LANES entries more.

Planets that start or end near the pericentre of an eccentric orbit, those whose motion was not
solved, and two bodies alone, of which nothing else errs, are done one by one, by
`galvi.fast.lanes.frames.near_parabola`.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.fast.lanes.frames import universal
from galvi.fast.lanes.frames.kepler_motion import COUNT, HEAD, MASS, MOST, STEP, dot
from galvi.fast.lanes.frames.near_parabola import follow_near_parabola
from galvi.fast.lanes.functions import square_root, two_product, two_sum
from galvi.fast.lanes.values import Lane, Truth
from galvi.fast.lanes.vectors import LANES, NOTHING, Lanes, spread
from galvi.kernels.compile.jit import jit_inline

TERMS = 10  # of a series
SMALL = 2e-6  # share of X up to which a correction of it is the last one
FARTHEST = 64.0  # largest |beta X^2| for which the series are accurate
NEAR = 0.5  # distance over the semi-major axis, below which doubles lose too much


@jit_inline
def kepler_drift(axes, numbers, share, state):
    """The planets of rows 4 to 7 of the state, in as many dimensions as ``axes`` has entries.

    The steps of Q and v are added with their rounding errors.
    """
    n = planets_of(numbers)
    for first in range(0, n, LANES):
        left = planets_in_lanes(axes, numbers, share, state, first) if n > 1 else 1
        while left > 0:
            planet = 0
            while left >> planet & 1 == 0:
                planet += 1
            left ^= 1 << planet
            planet += first
            mu = numbers[HEAD + n * MASS + planet]
            follow_near_parabola(mu, share * numbers[STEP], state, planet, n, len(axes))


@intrinsic
def planets_in_lanes(typingctx, axes, numbers, share, state, begin):
    """Moves a vector of planets; those that it leaves are the bits of the result."""
    D = axes.count

    def generate(context, builder, signature, values):
        known, rows = (
            context.make_array(signature.args[k])(context, builder, values[k]) for k in (1, 3)
        )
        width = builder.extract_value(rows.shape, 1)
        row = width.type
        n = builder.fptosi(builder.load(builder.gep(known.data, [row(COUNT)])), row)
        h = builder.load(builder.gep(known.data, [row(STEP)]))
        first = values[4]
        left = builder.sub(n, first)
        lanes = Lanes(context, builder, width, row(0))

        def address(data, place):
            place = builder.gep(data, [place])
            return builder.bitcast(place, NOTHING.type.as_pointer())

        def load(data, place):
            value = builder.load(address(data, place))
            value.align = 8
            return Lane(builder, value)

        def entry(r, x):
            begin = builder.add(builder.mul(width, row(r)), first)
            return builder.add(begin, builder.mul(n, row(x)))

        mask = _below(builder, left)
        t = Lane(builder, lanes.spread(builder.fmul(values[2], h)))
        masses = builder.add(row(HEAD), builder.mul(n, row(MASS)))
        mu = load(known.data, builder.add(first, masses))
        parts = [[load(rows.data, entry(r, x)) for x in range(D)] for r in range(4, 8)]
        moved, done = _moved(builder, lanes, mask, mu, t, *parts)
        every = builder.icmp_unsigned(">=", left, row(LANES))
        for r, before, vector in zip(range(4, 8), parts, moved, strict=True):
            for x, (old, new) in enumerate(zip(before, vector, strict=True)):
                lane = new.where(done, old)
                with builder.if_else(every) as (together, one_by_one):
                    with together:
                        store = builder.store(lane.value, address(rows.data, entry(r, x)))
                        store.align = 8
                    with one_by_one, cgutils.for_range(builder, left, intp=row) as inner:
                        number = builder.extract_element(lane.value, inner.index)
                        place = builder.add(entry(r, x), inner.index)
                        builder.store(number, builder.gep(rows.data, [place]))
        return builder.zext((mask & ~done).bits, row)

    return types.intp(axes, numbers, share, state, types.intp), generate


def _below(builder, count):
    """The lanes whose number is below a count."""
    numbers = ir.Constant(ir.VectorType(count.type, LANES), list(range(LANES)))
    return Truth(builder, builder.icmp_signed("<", numbers, spread(builder, count, LANES)))


def _moved(builder, lanes, mask, mu, t, q, q_low, v, v_low):
    """q, its low part, v and its low part after the time t, and where they are good."""
    r0 = dot(q, q).call("sqrt")
    inverse_0, eta = 1.0 / r0, dot(q, v)
    beta = 2.0 * mu / r0 - dot(v, v)
    zeta = mu - beta * r0
    limit = NEAR * mu
    usual = abs(beta) * r0 >= limit
    mask = mask & usual
    X, G, solved = _solved(builder, lanes, mask, mu, beta, r0, eta, zeta, t)
    r = r0 + (eta * G[0] + zeta * G[1])
    usual = usual & (abs(beta) * r >= limit)
    inverse = 1.0 / r
    f, g = -(mu * inverse_0) * G[1], t - mu * G[2]
    rate_f, rate_g = -(mu * inverse_0) * inverse * G[0], -(mu * inverse) * G[1]
    ways, turns = [], []
    for x, x_low, y, y_low in zip(q, q_low, v, v_low, strict=True):
        ways.append((f * x + g * y, f * x_low + g * y_low))
        turns.append((rate_f * x + rate_g * y, rate_f * x_low + rate_g * y_low))
    places, place_change = _added(q, q_low, ways)
    speeds, speed_change = _added(v, v_low, turns)
    # What rounding changed in v.v / 2 - mu / r is taken from the speed: it would add up.
    gained = 0.5 * speed_change + mu * place_change * (inverse_0 * inverse) / (r0 + r)
    fast = [high for high, _ in speeds]
    back = gained / dot(fast, fast)
    speeds = [(high, low - back * high) for high, low in speeds]
    ends = [
        [high for high, _ in places], [low for _, low in places],
        fast, [low for _, low in speeds],
    ]  # fmt: skip
    return ends, usual & solved


def _added(start, start_low, changes):
    """A vector after a change, in two parts, and the change of its square, to 1e-32 of it.

    The latter is change . (start + end), whose terms nearly cancel on a circle.
    """
    ends: list[Any] = []
    square: Any = None
    square_low: Any = 0.0
    for x, x_low, (far, far_low) in zip(start, start_low, changes, strict=True):
        end, rest = two_sum(x, far)
        end, rest = two_sum(end, rest.fused + (x_low + far_low))
        both, both_low = two_sum(x, end)
        term, term_low = two_product(both, far.exact)
        more = far * (both_low.fused + x_low + rest.fused) + far_low * both.fused
        square, carried = two_sum(square, term) if square is not None else (term, 0.0 * far)
        square_low = carried.fused + (term_low.fused + more) + square_low
        ends.append((end.fused, rest.fused))
    return ends, square.fused + square_low


def _solved(builder, lanes, mask, mu, beta, r0, eta, zeta, t):
    """X and G1 to G5 after the time t, and where it was found and is not too large."""
    place, changed = lanes.variable((t * beta / mu).value), lanes.variable(NOTHING)
    found = [lanes.variable(NOTHING) for _ in range(5)]
    with cgutils.for_range(builder, ir.Constant(ir.IntType(64), MOST)) as loop:
        X = Lane(builder, builder.load(place))
        G = universal.universal(beta, X, TERMS, exact=True)
        step = universal.correction(beta, r0, eta, zeta, X, G, t, lambda r: 1.0 / r)
        for variable, value in zip(found, G, strict=True):
            builder.store(value.value, variable)
        builder.store(step.value, changed)
        small = (abs(step) <= SMALL * abs(X)) | ~mask
        with builder.if_then(small.every):
            loop.do_break()
        far = universal.far_correction(
            beta, r0, eta, zeta, X, G, t, lambda x, y: x / y, square_root
        )
        builder.store((X + far).value, place)
    X, step = (Lane(builder, builder.load(one)) for one in (place, changed))
    solved = (abs(step) <= SMALL * abs(X)) & (abs(beta) * X * X <= FARTHEST)
    G = universal.moved(beta, [Lane(builder, builder.load(one)) for one in found], step)
    return X + step, G, solved


@jit_inline
def planets_of(numbers):
    """n."""
    return int(numbers[COUNT])
