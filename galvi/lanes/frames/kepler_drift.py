"""Kepler's motions of all planets over a step, in vector instructions over the planets.

Numbers as in `galvi.lanes.frames.kepler_motion`. Row 4 of the state holds D n entries, Q by
coordinates, then D entries of the barycentre. Row 5 holds their low parts, row 6 the velocities,
and row 7 the low parts of these. Rows have at least LANES entries more.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.compile.jit import jit_inline
from galvi.lanes.frames import universal
from galvi.lanes.frames.kepler_motion import COUNT, HEAD, MASS, MAX_CORRECTIONS, NAN, STEP, dot
from galvi.lanes.functions import square_root, two_product, two_sum
from galvi.lanes.values import Lane, Truth
from galvi.lanes.vectors import LANES, ZEROS, Lanes, spread

LAST_CORRECTION_RATIO = 2e-6  # largest ratio to X of a correction that is the last one
LARGEST_ANOMALY_CHANGE = 8.0  # largest change of the mean anomaly in a step, radians


@jit_inline
def kepler_drift(axes, numbers, share, state):
    """Move the planets of rows 4 to 7 of the state along Kepler's orbits; ``axes`` has D entries.

    The changes of Q and v are added with their rounding errors. NaN where the iteration for
    Kepler's equation did not converge, or the mean anomaly of a step exceeds
    LARGEST_ANOMALY_CHANGE.
    """
    n = planets_of(numbers)
    for first in range(0, n, LANES):
        planets_in_lanes(axes, numbers, share, state, first)


@intrinsic
def planets_in_lanes(typingctx, axes, numbers, share, state, begin):
    """Move LANES planets, from index ``begin`` on, or those up to the last."""
    D = axes.count

    def generate(context, builder, signature, values):
        constants, rows = (
            context.make_array(signature.args[k])(context, builder, values[k]) for k in (1, 3)
        )
        width = builder.extract_value(rows.shape, 1)
        row = width.type
        n = builder.fptosi(builder.load(builder.gep(constants.data, [row(COUNT)])), row)
        first = values[4]
        remaining = builder.sub(n, first)
        lanes = Lanes(context, builder, width, row(0))

        def address(array, index):
            return builder.bitcast(builder.gep(array, [index]), ZEROS.type.as_pointer())

        def load(array, index):
            value = builder.load(address(array, index))
            value.align = 8
            return Lane(builder, value)

        def entry(r, x):
            begin = builder.add(builder.mul(width, row(r)), first)
            return builder.add(begin, builder.mul(n, row(x)))

        mask = _below(builder, remaining)
        h = Lane(builder, lanes.spread(lanes.number(constants.data, row(STEP))))
        share_lane = Lane(builder, lanes.spread(values[2]))
        masses = builder.add(row(HEAD), builder.mul(n, row(MASS)))
        mu = load(constants.data, builder.add(first, masses))
        parts = [[load(rows.data, entry(r, x)) for x in range(D)] for r in range(4, 8)]
        moved, solved = _after_step(builder, lanes, mask, mu, h, share_lane, *parts)
        is_full = builder.icmp_unsigned(">=", remaining, row(LANES))
        for r, vector in zip(range(4, 8), moved, strict=True):
            for x, new in enumerate(vector):
                lane = new.where(solved, NAN)
                with builder.if_else(is_full) as (together, one_by_one):
                    with together:
                        store = builder.store(lane.value, address(rows.data, entry(r, x)))
                        store.align = 8
                    with one_by_one, cgutils.for_range(builder, remaining, intp=row) as inner:
                        number = builder.extract_element(lane.value, inner.index)
                        index = builder.add(entry(r, x), inner.index)
                        builder.store(number, builder.gep(rows.data, [index]))
        return context.get_dummy_value()

    return types.void(axes, numbers, share, state, types.intp), generate


def _below(builder, count):
    """The `Truth` whether the index of each lane is below ``count``."""
    numbers = ir.Constant(ir.VectorType(count.type, LANES), list(range(LANES)))
    return Truth(builder, builder.icmp_signed("<", numbers, spread(builder, count, LANES)))


def _after_step(builder, lanes, mask, mu, h, share, q, q_low, v, v_low):
    """[q, its low part, v, its low part] after ``share`` steps h, and where the iteration converged
    and the step is short enough."""
    r0 = dot(q, q).call("sqrt")
    inverse_0, eta = 1.0 / r0, dot(q, v)
    beta = 2.0 * mu / r0 - dot(v, v)
    zeta = mu - beta * r0
    mean_X, t = h * beta / mu, h * share
    X, G, solved = _solve_anomaly(builder, lanes, mask, mean_X * share, beta, r0, eta, zeta, t)
    solved = solved & (
        mean_X * mean_X * abs(beta) <= LARGEST_ANOMALY_CHANGE * LARGEST_ANOMALY_CHANGE
    )
    r = r0 + (eta * G[0] + zeta * G[1])
    inverse = 1.0 / r
    f, g = -(mu * inverse_0) * G[1], t - mu * G[2]
    rate_f, rate_g = -(mu * inverse_0) * inverse * G[0], -(mu * inverse) * G[1]
    displacements, velocity_changes = [], []
    for x, x_low, y, y_low in zip(q, q_low, v, v_low, strict=True):
        displacements.append((f * x + g * y, f * x_low + g * y_low))
        velocity_changes.append((rate_f * x + rate_g * y, rate_f * x_low + rate_g * y_low))
    positions, position_change = _add_compensated(q, q_low, displacements)
    velocities, velocity_change = _add_compensated(v, v_low, velocity_changes)
    # The change of v.v / 2 - mu / r by rounding is corrected by the speed: it would add up.
    end_q, end_v = ([high for high, _ in vector] for vector in (positions, velocities))
    r = dot(end_q, end_q).call("sqrt")
    energy_gain = 0.5 * velocity_change + mu * position_change * inverse_0 / (r * (r0 + r))
    correction = energy_gain / dot(end_v, end_v)
    velocities = [(high, low - correction * high) for high, low in velocities]
    ends = [
        end_q,
        [low for _, low in positions],
        end_v,
        [low for _, low in velocities],
    ]
    return ends, solved


def _add_compensated(start, start_low, changes):
    """A vector after a change, as pairs (high, low), and the change of its square.

    The change of the square, change . (start + end), is accurate to 1e-32 of the square: its terms
    nearly cancel on a circle.
    """
    ends: list[Any] = []
    square: Any = None
    square_low: Any = 0.0
    for x, x_low, (change, change_low) in zip(start, start_low, changes, strict=True):
        end, end_low = two_sum(x, change)
        end, end_low = two_sum(end, end_low.fused + (x_low + change_low))
        both, both_low = two_sum(x, end)
        term, term_low = two_product(both, change.exact)
        cross_terms = change * (both_low.fused + x_low + end_low.fused) + change_low * both.fused
        square, carried = two_sum(square, term) if square is not None else (term, 0.0 * change)
        square_low = carried.fused + (term_low.fused + cross_terms) + square_low
        ends.append((end.fused, end_low.fused))
    return ends, square.fused + square_low


def _solve_anomaly(builder, lanes, mask, mean, beta, r0, eta, zeta, t):
    """X and G1 to G5 after the time t, and where X converged; the iteration starts from ``mean``,
    the X of the mean motion, and ends when the lanes of ``mask`` have converged."""
    reach = universal.LARGEST_ANOMALY_LEAD / beta.call("sqrt")
    ends = (lanes.variable(x.value) for x in (mean, mean - reach, mean + reach))
    anomaly, low, high = ends
    last_step = lanes.variable(ZEROS)
    functions = [lanes.variable(ZEROS) for _ in range(5)]
    with cgutils.for_range(builder, ir.Constant(ir.IntType(64), MAX_CORRECTIONS)) as loop:
        X = Lane(builder, builder.load(anomaly))
        G = universal.universal(beta, X, universal.SERIES_TERMS, exact=True)
        step = universal.correction(beta, r0, eta, zeta, X, G, t, lambda r: 1.0 / r)
        for variable, value in zip(functions, G, strict=True):
            builder.store(value.value, variable)
        builder.store(step.value, last_step)
        small = (abs(step) <= LAST_CORRECTION_RATIO * abs(X)) | ~mask
        with builder.if_then(small.all):
            loop.do_break()
        correction = universal.far_correction(
            beta, r0, eta, zeta, X, G, t, lambda x, y: x / y, square_root
        )
        limits = (Lane(builder, builder.load(end)) for end in (low, high))
        bracket = universal.bracketed(X, correction, *limits, lambda c, x, y: x.where(c, y))
        for variable, value in zip((anomaly, low, high), bracket, strict=True):
            builder.store(value.value, variable)
    X, step = (Lane(builder, builder.load(pointer)) for pointer in (anomaly, last_step))
    solved = abs(step) <= LAST_CORRECTION_RATIO * abs(X)
    G = universal.shifted(
        beta, [Lane(builder, builder.load(pointer)) for pointer in functions], step
    )
    return X + step, G, solved


@jit_inline
def planets_of(numbers):
    """The number of planets."""
    return int(numbers[COUNT])
