"""Vector instructions of `galvi.lanes.clocks.advance`, in the form of `galvi.lanes.stages`."""

from __future__ import annotations

from typing import Any

from numba import types

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.stages import in_lanes, square
from galvi.lanes.values import Lane

POTENTIAL, RATES, KINETIC, EXCESS, RATE, LENGTH = range(6)  # rows of totals
# Columns of pairs, and their number.
ONTO_FIRST, ONTO_SECOND, PRODUCT, PRODUCT_LOW, RATE_WEIGHT, TURN, COLUMNS = range(7)

# The sum of a row over the stages.
sum_of = in_lanes(lambda at, rows, row: rows[row, 0], types.float64)


@in_lanes
def attract(at, shifts, gaps, pairs, seconds, first, begin, end, pulls, turns, totals):
    """Add the pairs ``begin`` to ``end``, of a body with those of ``seconds``, to the rows of pulls
    and turns of both, and to the rows POTENTIAL and RATES of the totals."""
    builder, n = at.builder, len(at.axes)
    shift = [shifts[first, x] for x in at.axes]
    body_rows: list[Any] = [(rows, (first, x)) for rows in (pulls, turns) for x in at.axes]
    body_rows += [(totals, POTENTIAL), (totals, RATES)]
    sums = [at.variable(rows[index].value) for rows, index in body_rows]

    def add(pointer, amount):
        builder.store((Lane(builder, builder.load(pointer)) + amount).value, pointer)

    with cgutils.for_range(builder, end, start=begin, intp=end.type) as loop:
        row, start = (builder.mul(loop.index, loop.index.type(size)) for size in (COLUMNS, n))
        second = at.number(seconds.data, loop.index)
        gap = [shift[x] - shifts[second, x] + gaps.number(start, x) for x in at.axes]
        inverse = at.inverse.root(square(gap))
        third = inverse * inverse * inverse
        rate_term = pairs.number(row, RATE_WEIGHT) * third
        for column in (PRODUCT_LOW, PRODUCT):
            add(sums[2 * n], pairs.number(row, column) * inverse)
        add(sums[2 * n + 1], rate_term)
        turn = pairs.number(row, TURN) * third * inverse * inverse
        # Rounded one by one: pulls from both sides cancel, and Sitnikov's body stays on its axis.
        onto_first, onto_second = (
            (pairs.number(row, n) * third).exact for n in (ONTO_FIRST, ONTO_SECOND)
        )
        for x, component in enumerate(gap):
            add(sums[x], -onto_first * component)
            add(sums[n + x], turn * component)
            pulls[second, x] = pulls[second, x] + onto_second * component
            turns[second, x] = turns[second, x] - turn * component
    for (rows, index), total in zip(body_rows, sums, strict=True):
        rows[index] = Lane(builder, builder.load(total))


@in_lanes
def set_clock(at, parts, energy, energy_low, totals, changes):
    """Set g, h b g and 3 (H - E0) / (2 S) at each stage; reset the sums they come from, and the
    changes, to 0."""
    rate = at.inverse.root(totals[RATES])
    inverse = rate * rate
    excess = ((totals[KINETIC] - totals[POTENTIAL]) - energy) - energy_low
    totals[RATE], totals[LENGTH] = rate, rate * parts[0]
    totals[EXCESS] = 1.5 * (excess * inverse)
    totals[KINETIC] = totals[POTENTIAL] = totals[RATES] = at.none
    for row in range(4):
        changes[row] = at.none


@in_lanes
def kick(at, totals, pulls, turns, row, inverse_mass, slopes, share, changes):
    """Set new slopes of a body's velocity; reset its pulls and turns to 0.

    Parameters
    ----------
    light
        1 / M, or 0 for a light body
    """
    length, excess_over_mass = totals[LENGTH], totals[EXCESS] * inverse_mass
    new = [length * (pulls[row, x] - excess_over_mass * turns[row, x]) for x in at.axes]
    at.average_slopes(slopes, row, new, share, changes, 0)
    for x in at.axes:
        pulls[row, x] = turns[row, x] = at.none


@in_lanes
def drift(at, matrix, state, low, mean, row, half_mass, totals, kicks, slopes, share, changes):
    """Set new slopes of a body's position, from its velocity, and add its kinetic energy to the
    totals.

    Parameters
    ----------
    mean : array, shape (dimension,)
        the velocity of the centre of mass, to which energies refer
    half
        M / 2
    """
    increments = enumerate(at.sums_of(matrix, kicks, row))
    v = [state.number(row, x) + (low.number(row, x) + kick_x) for x, kick_x in increments]
    relative = [v_x - mean.number(row.type(0), x) for x, v_x in enumerate(v)]
    totals[KINETIC] = totals[KINETIC] + half_mass * square(relative)
    at.average_slopes(slopes, row, [totals[LENGTH] * v_x for v_x in v], share, changes, 2)


@in_lanes
def combine(at, matrix, values, row, out):
    """out <- sum_j values_j matrix_j for all axes of a body."""
    for x, total in enumerate(at.sums_of(matrix, values, row)):
        out[row, x] = total
