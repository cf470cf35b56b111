"""Vector instructions on rows of stages, for `galvi.fast.lanes.clocks` and for forces on points.

Each function is called with the form of the kernel, then with arrays, whole and real numbers. The
first row of a body is its number times the dimension.

form  tuples of as many numbers as there are dimensions and lanes of a vector; the stages s, and
      their number padded P
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from galvi.fast.lanes.reciprocals import Reciprocals
from galvi.fast.lanes.values import Lane
from galvi.fast.lanes.vectors import DOUBLE, Lanes

POTENTIAL, RATES, KINETIC, EXCESS, RATE, LENGTH = range(6)  # rows of totals
CHANGE, SIZE = 0, 1  # rows of changes, for velocities; then the same for places
ONTO_FIRST, ONTO_SECOND, PRODUCT, PRODUCT_LOW, PACE, COLUMNS = range(6)  # of pairs


class Rows:
    """The rows of an array at some stages, and its numbers; a row may be counted from another."""

    def __init__(self, at, data):
        self.at, self.data = at, data

    def row(self, place):
        return self.at.plus(*place) if isinstance(place, tuple) else self.at.padded.type(place)

    def __getitem__(self, place):
        return Lane(self.at.builder, self.at.load(self.data, self.row(place)))

    def __setitem__(self, place, lane):
        self.at.store(lane.value, self.data, self.row(place))

    def number(self, *place):
        """A number of an array in one dimension, in all lanes."""
        return Lane(self.at.builder, self.at.spread(self.at.number(self.data, self.row(place))))


class Stages(Lanes):
    """As many stages of a step as a vector has lanes, for point masses in some dimensions."""

    def __init__(self, context, builder, form, given, chunk):
        super().__init__(context, builder, builder.extract_value(given, 3), chunk, form[1].count)
        self.stages, self.axes = builder.extract_value(given, 2), range(form[0].count)
        self.inverse, self.none = Reciprocals(context, builder), Lane(builder, self.nothing)

    def given(self, kind, value):
        """An argument: rows of an array, a number in all lanes, or a whole number."""
        if isinstance(kind, types.Array):
            return Rows(self, self.data(kind, value))
        return Lane(self.builder, self.spread(value)) if isinstance(kind, types.Float) else value

    def sums_of(self, matrix, values, row):
        """sum_j values_j matrix_j of a body, for each axis."""
        first = [self.nothing] * len(self.axes)
        sums = self.sums(first, matrix.data, row.type(0), values.data, row, self.stages)
        return [Lane(self.builder, total) for total in sums]

    def renew(self, slopes, row, new, share, changes, first):
        """A body's slopes become a share of the new ones and the rest of the old; changes add up
        from the row ``first`` on."""
        changed, size = changes[first + CHANGE], changes[first + SIZE]
        for x, one in enumerate(new):
            old = slopes[row, x]
            changed, size = changed + abs(one - old), size + abs(one)
            slopes[row, x] = share * one + (1.0 - share) * old
        changes[first + CHANGE], changes[first + SIZE] = changed, size


def square(vector):
    """|vector|^2."""
    return sum((one * one for one in vector[1:]), vector[0] * vector[0])


def in_lanes(code, returned=types.void):
    """An intrinsic function that generates ``code(stages, *arguments)`` for all stages of a step.

    What the code returns is summed over the stages.
    """

    @intrinsic
    def called(typingctx, form, *arguments):
        def generate(context, builder, signature, values):
            given = [builder.extract_value(values[1], i) for i in range(len(arguments))]
            padded, width = builder.extract_value(values[0], 3), form.types[1].count
            kind = ir.VectorType(DOUBLE, width)
            total = cgutils.alloca_once_value(builder, ir.Constant(kind, [0.0] * width))
            chunks = builder.udiv(padded, padded.type(width))
            with cgutils.for_range(builder, chunks, intp=padded.type) as loop:
                at = Stages(context, builder, form.types, values[0], loop.index)
                found = code(at, *map(at.given, arguments, given))
                if found is not None:
                    builder.store(at.add(builder.load(total), found.value), total)
            if returned == types.void:
                return context.get_dummy_value()
            name = f"llvm.vector.reduce.fadd.v{width}f64"
            shape = ir.FunctionType(DOUBLE, [DOUBLE, kind])
            add = cgutils.get_or_insert_function(builder.module, shape, name)
            return builder.call(add, [DOUBLE(-0.0), builder.load(total)], fastmath=("reassoc",))

        return returned(form, types.StarArgTuple(arguments)), generate

    return called


sum_of = in_lanes(lambda at, rows, row: rows[row, 0], types.float64)  # of a row


@in_lanes
def attract(at, shifts, gaps, pairs, seconds, first, begin, end, pulls, turns, totals):
    """What the pairs ``begin`` to ``end`` of one body with the ``seconds`` add to their rows, the
    potential and the rate of the clock."""
    builder, n = at.builder, len(at.axes)
    here = [shifts[first, x] for x in at.axes]
    owned: list[Any] = [(rows, (first, x)) for rows in (pulls, turns) for x in at.axes]
    owned += [(totals, POTENTIAL), (totals, RATES)]
    sums = [at.variable(rows[place].value) for rows, place in owned]

    def add(place, amount):
        builder.store((Lane(builder, builder.load(place)) + amount).value, place)

    with cgutils.for_range(builder, end, start=begin, intp=end.type) as loop:
        row, start = (builder.mul(loop.index, loop.index.type(size)) for size in (COLUMNS, n))
        second = at.number(seconds.data, loop.index)
        gap = [here[x] - shifts[second, x] + gaps.number(start, x) for x in at.axes]
        inverse = at.inverse.root(square(gap))
        third = inverse * inverse * inverse
        pace = pairs.number(row, PACE) * third
        for column in (PRODUCT_LOW, PRODUCT):
            add(sums[2 * n], pairs.number(row, column) * inverse)
        add(sums[2 * n + 1], pace)
        turn = pace * inverse * inverse
        # Rounded one by one: pulls from both sides cancel, and Sitnikov's body stays on its axis.
        onto_first, onto_second = (
            (pairs.number(row, n) * third).exact for n in (ONTO_FIRST, ONTO_SECOND)
        )
        for x, one in enumerate(gap):
            add(sums[x], -onto_first * one)
            add(sums[n + x], turn * one)
            pulls[second, x] = pulls[second, x] + onto_second * one
            turns[second, x] = turns[second, x] - turn * one
    for (rows, place), total in zip(owned, sums, strict=True):
        rows[place] = Lane(builder, builder.load(total))


@in_lanes
def set_clock(at, parts, energy, energy_low, totals, changes):
    """g, h b g and 3 (H - E0) / (2 S) at each stage; what they come from, and changes, <- 0."""
    rate = at.inverse.root(totals[RATES])
    inverse = rate * rate
    excess = ((totals[KINETIC] - totals[POTENTIAL]) - energy) - energy_low
    totals[RATE], totals[LENGTH] = rate, rate * parts[0]
    totals[EXCESS] = 1.5 * (excess * inverse)
    totals[KINETIC] = totals[POTENTIAL] = totals[RATES] = at.none
    for row in range(4):
        changes[row] = at.none


@in_lanes
def kick(at, totals, pulls, turns, row, light, slopes, share, changes):
    """New slopes of a body's velocity; pulls and turns <- 0.

    light  1 / M, or 0 where it does not feel H - E0
    """
    length, turned = totals[LENGTH], totals[EXCESS] * light
    new = [length * (pulls[row, x] - turned * turns[row, x]) for x in at.axes]
    at.renew(slopes, row, new, share, changes, 0)
    for x in at.axes:
        pulls[row, x] = turns[row, x] = at.none


@in_lanes
def drift(at, matrix, state, low, row, half, totals, kicks, slopes, share, changes):
    """New slopes of a body's place, from its velocity, whose energy is added to the totals.

    half  M / 2
    """
    kicked = enumerate(at.sums_of(matrix, kicks, row))
    v = [state.number(row, x) + (low.number(row, x) + one) for x, one in kicked]
    totals[KINETIC] = totals[KINETIC] + half * square(v)
    at.renew(slopes, row, [totals[LENGTH] * one for one in v], share, changes, 2)


@in_lanes
def combine(at, matrix, values, row, out):
    """out <- sum_j values_j matrix_j, for all axes of a body."""
    for x, total in enumerate(at.sums_of(matrix, values, row)):
        out[row, x] = total
