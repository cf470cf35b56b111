"""The decisions of an iteration for eight members at once.

As galvi.kernels.nystrom.solve.verdict, galvi.fast.lanes.countdown and
galvi.kernels.nystrom.step.terms_to_extrapolate decide for one.
"""

from __future__ import annotations

import math

from llvmlite import ir
from numba.core import cgutils

from galvi.fast.lanes.countdown import CLEAR, FAR, MANY, NOISE, OVER, PATIENCE, SOON
from galvi.fast.lanes.members.rows import CONDITION, Mask, Variable, larger, whole_number
from galvi.fast.lanes.vectors import LANES
from galvi.kernels.nystrom.solve import DIVERGED, FIXED_POINT_PASSES, FLOOR, IDLE, NOT_FINITE
from galvi.kernels.nystrom.step import EPSILON


class Judgement:
    """Which members of a step still iterate, and which failed.

    active   members whose iteration goes on; what it has computed for the others is not changed
    solved   members whose step is solved
    code     why a member failed, 0 if it did not
    """

    def __init__(self, builder, row):
        self.builder, self.row = builder, row
        none = ir.Constant(CONDITION, [0] * LANES)
        self.active, self.solved = Mask(builder, none), Mask(builder, none)
        self.code = Variable(builder)
        self.last, self.rate, self.least, self.idle = (Variable(builder) for _ in range(4))

    def begin(self, alive):
        """A step begins for the members that are alive."""
        self.active.set(alive)
        self.solved.set(ir.Constant(CONDITION, [0] * LANES))
        self.code.set(0.0)
        for variable, number in (
            (self.last, math.inf), (self.rate, 1.0), (self.least, math.inf), (self.idle, 0.0)
        ):  # fmt: skip
            variable.set(number)

    def judge(self, change, tolerance):
        """After a pass with this largest relative change, a lane; tolerance is one too."""
        solved, finite = self.verdict(change, tolerance, self.active.value)
        self.conclude(solved, finite, self.idle.lane >= 2.0 * IDLE)

    def verdict(self, change, tolerance, judged):
        """Whether each member is solved, and whether its change is finite.

        judged  members whose history takes note of the change
        """
        builder = self.builder
        last, before, least = self.last.lane, self.rate.lane, self.least.lane
        rate = (change / last).where(last < math.inf, 1.0)
        slower = larger(rate, before)
        less = change < least
        idle = (least.same(0.0)).where(less, self.idle.lane + 1.0)
        for variable, lane in (
            (self.last, change), (self.rate, rate), (self.least, change.where(less, least)),
            (self.idle, idle),
        ):  # fmt: skip
            variable.set(lane.where(judged, variable.lane))
        enough = builder.or_(change <= tolerance, change * slower <= tolerance * (1.0 - slower))
        at_rest = builder.and_(idle >= IDLE, self.least.lane <= FLOOR)
        return builder.or_(enough, at_rest), change < math.inf

    def conclude(self, solved, finite, diverged):
        """Members that are solved, diverge or are not finite end their iteration."""
        builder, active = self.builder, self.active.value
        solved = builder.and_(solved, finite)
        ends = builder.or_(solved, builder.or_(builder.not_(finite), diverged))
        code = self.code.lane.same(float(NOT_FINITE)).where(builder.not_(finite), float(DIVERGED))
        failed = builder.and_(active, builder.and_(ends, builder.not_(solved)))
        self.code.set(code.where(failed, self.code.lane))
        self.solved.set(builder.or_(self.solved.value, builder.and_(active, solved)))
        self.active.set(builder.and_(active, builder.not_(ends)))

    def end(self, finite):
        """After the last pass; ``finite`` is whether the state at the step's end is.

        Returns the members whose step is done, and those that failed.
        """
        builder = self.builder
        done = builder.and_(self.solved.value, finite)
        lost = builder.and_(self.solved.value, builder.not_(finite))
        code = self.code.lane
        code = code.same(float(DIVERGED)).where(self.active.value, code)
        self.code.set(code.same(float(NOT_FINITE)).where(lost, code))
        return done, self.code.lane > 0.0


class Countdown(Judgement):
    """As `Judgement`, where the passes left are counted once a change is near round-off.

    left     passes left
    changes  the last ones, the newest first
    """

    def __init__(self, builder, row):
        super().__init__(builder, row)
        self.left = Variable(builder)
        self.changes = [Variable(builder) for _ in range(OVER)]

    def begin(self, alive):
        super().begin(alive)
        self.left.set(float(FIXED_POINT_PASSES))
        for change in self.changes:
            change.set(math.inf)

    def judge(self, change, tolerance):
        """As ``judged`` of galvi.fast.lanes.countdown."""
        builder = self.builder
        both, either, negated = builder.and_, builder.or_, builder.not_
        last, second, third, first = (known.lane for known in self.changes)
        for known, value in zip(self.changes, (change, last, second, third), strict=True):
            known.set(value)
        far = larger(change.same(SOON), tolerance * FAR)
        quick = both(both(change > far, change < 0.5 * last), last < math.inf)
        slow = negated(quick)
        self.left.set((self.left.lane - 1.0).where(slow, self.left.lane))
        solved, finite = self.verdict(change, tolerance, slow)
        self.last.set(change)
        solved, idle, least = both(solved, slow), self.idle.lane, self.least.lane
        once_more = both(both(solved, idle < IDLE), both(tolerance < CLEAR, self.left.lane > 0.0))
        self.left.set(change.same(1.0).where(once_more, self.left.lane))
        patient = both(both(solved, least > NOISE), both(idle >= IDLE, idle < PATIENCE))
        solved = both(solved, negated(either(once_more, patient)))
        counted = both(slow, both(change > CLEAR, change < SOON))
        self.count(counted, change, last, second, first, tolerance)
        over = both(slow, self.left.lane <= 0.0)
        diverged = both(both(slow, idle >= 2.0 * IDLE), negated(patient))
        self.conclude(either(solved, over), finite, diverged)

    def count(self, members, change, last, second, first, tolerance):
        """The passes left of some members, by the rate of their changes."""
        builder = self.builder
        rate = (change / last).call("sqrt")
        two = larger(change / last, last / second)
        rate = two.where(second < math.inf, rate)
        mean = (change / first).call("sqrt").call("sqrt")
        rate = mean.where(first < math.inf, rate)
        members = builder.and_(members, builder.and_(rate > 0.0, rate < 1.0))
        going, count, rest = Mask(builder, members), Variable(builder), Variable(builder, change)
        with cgutils.for_range(builder, self.row(MANY), intp=self.row) as loop:
            more = rest.lane * rate > tolerance * (1.0 - rate)
            going.set(builder.and_(going.value, more))
            with builder.if_then(builder.not_(going.any)):
                loop.do_break()
            count.set((count.lane + 1.0).where(going.value, count.lane))
            rest.set(rest.lane * rate)
        self.left.set(count.lane.where(members, self.left.lane))


def terms_kept(builder, row, count, size, growth):
    """How many Legendre terms to extrapolate, a lane, as ``terms_to_extrapolate``.

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
        later = builder.icmp_unsigned(">", loop.index, row(0))
        later = builder.select(
            later, ir.Constant(CONDITION, [1] * LANES), ir.Constant(CONDITION, [0] * LANES)
        )
        outgrown = builder.and_(later, own > 4.0 * largest.lane)
        open_.set(builder.and_(open_.value, builder.not_(outgrown)))
        cost = EPSILON * largest.lane * growth(loop.index)
        kept = builder.add(loop.index, row(1))
        first = builder.select(builder.icmp_unsigned("<", kept, second), kept, second)
        after = builder.add(first, row(1))
        after = builder.select(builder.icmp_unsigned("<", after, last), after, last)
        for index in (first, after):
            cost = larger(size(index) * growth(index), cost)
        better = builder.and_(open_.value, cost <= best.lane)
        best.set(cost.where(better, best.lane))
        number = whole_number(builder, kept)
        terms.set(number.where(better, terms.lane))
    return terms.lane
