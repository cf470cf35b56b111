"""Rows of numbers for eight members: loads, stores and sums over the stages of a step, and the
decisions of their iteration.

An array (rows, s, 8) holds a number for each stage and member, one of (rows, 8) a number for each
member, and a matrix (rows, s) the same number for all members.
"""

from __future__ import annotations

import math

from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.constants import EPSILON
from galvi.kernels.lie.arithmetic import larger, where
from galvi.kernels.nystrom.solve import DIVERGED, GOING, NOT_FINITE, gives_low_parts
from galvi.lanes.values import Lane, Truth
from galvi.lanes.vectors import DOUBLE, LANES, NOTHING, VECTOR, Lanes, spread

ROWS_TOGETHER = 6  # rows that are summed together: sums stay in registers
ALL = ir.Constant(ir.VectorType(ir.IntType(1), LANES), [1] * LANES)


class MemberLanes(Lanes):
    """Loads and stores of eight members at one stage, with the interface of `Lanes`."""

    def __init__(self, context, builder, stages, stage):
        self.stages, self.stage = stages, stage
        width = builder.mul(stages, ir.Constant(stages.type, LANES))
        super().__init__(context, builder, width, stage)

    def factor(self, matrix, row):
        """A number of a matrix at this stage, in all lanes."""
        place = self.builder.add(self.builder.mul(row, self.stages), self.stage)
        scalar = self.builder.load(self.builder.gep(matrix, [place]))
        return super().spread(scalar)

    def number(self, data, row, column=None):
        """Numbers of the members: of a row (8,), or of one (s, 8) at a stage."""
        eight = ir.Constant(row.type, LANES)
        if column is None:
            place = self.builder.mul(row, eight)
        else:
            column = self.builder.mul(column, eight)
            place = self.builder.add(self.builder.mul(row, self.padded), column)
        address = self.builder.bitcast(self.builder.gep(data, [place]), VECTOR.as_pointer())
        value = self.builder.load(address)
        value.align = 8
        return value

    def spread(self, vector):
        """The same: each member has its own number."""
        return vector

    def sums(self, first, factors, start, values, row, stages):
        """As `Lanes.sums`, for a few rows at a time."""
        found = []
        for k in range(0, len(first), ROWS_TOGETHER):
            part = first[k : k + ROWS_TOGETHER]
            found += super().sums(part, factors, start, values, self.plus(row, k), stages)
        return found

    def keep(self, vector, data, row):
        """Store one number for each member, in a row (8,)."""
        place = self.builder.mul(row, ir.Constant(row.type, LANES))
        address = self.builder.bitcast(self.builder.gep(data, [place]), VECTOR.as_pointer())
        self.builder.store(vector, address).align = 8


class Mask:
    """A truth value for each member that changes, at first true."""

    def __init__(self, builder):
        self.builder = builder
        self.place = cgutils.alloca_once(builder, ALL.type)
        builder.store(ALL, self.place)

    @property
    def value(self):
        """The current truth values."""
        return Truth(self.builder, self.builder.load(self.place))

    def set(self, truth):
        """Change them."""
        self.builder.store(truth.value, self.place)


class Variable:
    """A number for each member that changes."""

    def __init__(self, builder, number=0.0):
        self.builder = builder
        self.place = cgutils.alloca_once(builder, VECTOR)
        self.set(number)

    @property
    def lane(self):
        """The current numbers, whose operations are rounded one by one."""
        return Lane(self.builder, self.builder.load(self.place), ())

    def set(self, number):
        """Change them, to a lane or one number for all."""
        zero = Lane(self.builder, NOTHING, ())
        self.builder.store(zero.same(number).value, self.place)


def splat(builder, scalar):
    """One number in all lanes."""
    return Lane(builder, spread(builder, scalar, LANES), ())


def whole_number(builder, whole):
    """An integer as a number in all lanes."""
    return splat(builder, builder.uitofp(whole, DOUBLE))


class Judgement:
    """Which members of a step still iterate, and which failed.

    rule     begins a history of so many numbers, and judges a pass by it, in lanes
    active   members whose iteration goes on; what it has computed for the others is not changed
    code     how the iteration of each member ended, or GOING
    settled  members of which a pass has changed little, from whose slopes low parts are formed
    settles  those whose last pass was the first of these; they iterate on
    """

    def __init__(self, builder, rule):
        self.begin_history, self.decide, size = rule
        self.alive, self.active, self.code = Mask(builder), Mask(builder), Variable(builder)
        self.settled, self.settles = Mask(builder), Mask(builder)
        self.numbers = [Variable(builder) for _ in range(size)]

    def __getitem__(self, k):
        return self.numbers[k].lane

    def __setitem__(self, k, number):
        self.numbers[k].set(number)

    def begin(self, alive):
        """A step begins for the members that are alive."""
        self.alive.set(alive)
        self.active.set(alive)
        self.settled.set(~alive)
        self.settles.set(alive & ~alive)  # none
        self.code.set(GOING)
        self.begin_history(self)

    def judge(self, change, tolerance):
        """After a pass with this largest relative change, a lane; tolerance is one too."""
        active = self.active.value
        settles = active & ~self.settled.value & gives_low_parts(change, tolerance)
        self.settles.set(settles)
        self.settled.set(self.settled.value | settles)
        code = where(active, self.decide(change, tolerance, self), self.code.lane)
        code = where(settles, GOING, code)
        self.code.set(code)
        self.active.set(active & (code > DIVERGED))

    def end(self, finite):
        """After the last pass; ``finite`` is whether the state at the step's end is.

        Returns the members whose step is done, and those that failed.
        """
        code = self.code.lane
        code = where((code < NOT_FINITE) & ~finite, NOT_FINITE, code)
        code = where(code > DIVERGED, DIVERGED, code)
        self.code.set(code)
        alive = self.alive.value
        return alive & (code < NOT_FINITE), alive & (code >= NOT_FINITE)


def terms_kept(builder, row, count, size, growth):
    """How many Legendre terms to extrapolate, a lane, as
    galvi.kernels.nystrom.step.terms_to_extrapolate for one member.

    count   l, the number of terms that can be
    size    (index) -> the magnitudes of a term, a lane
    growth  (index) -> by how much it grows, in all lanes
    """
    largest, best, terms = Variable(builder), Variable(builder, math.inf), Variable(builder, 1.0)
    open_ = Mask(builder)
    with cgutils.for_range(builder, count, intp=row) as loop:
        largest.set(larger(size(loop.index), largest.lane))
    second, last = builder.sub(count, row(2)), builder.sub(count, row(1))
    one = builder.icmp_unsigned("<", count, row(2))
    second = builder.select(one, row(0), second)
    with cgutils.for_range(builder, count, intp=row) as loop:
        own = size(loop.index) * growth(loop.index)
        first = builder.icmp_unsigned("==", loop.index, row(0))
        still = builder.select(first, ALL, (own <= 4.0 * largest.lane).value)
        open_.set(open_.value & Truth(builder, still))
        cost = EPSILON * largest.lane * growth(loop.index)
        kept = builder.add(loop.index, row(1))
        first = builder.select(builder.icmp_unsigned("<", kept, second), kept, second)
        after = builder.add(first, row(1))
        after = builder.select(builder.icmp_unsigned("<", after, last), after, last)
        for index in (first, after):
            cost = larger(size(index) * growth(index), cost)
        better = open_.value & (cost <= best.lane)
        best.set(cost.where(better, best.lane))
        number = whole_number(builder, kept)
        terms.set(number.where(better, terms.lane))
    return terms.lane
