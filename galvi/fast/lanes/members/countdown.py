"""The decisions of galvi.fast.lanes.countdown for eight members at once."""

from __future__ import annotations

import math

from numba.core import cgutils

from galvi.fast.lanes.countdown import (
    CLEAR,
    FAR,
    MANY,
    NOISE,
    OVER,
    PATIENCE,
    SOON,
)
from galvi.fast.lanes.members.judgement import Judgement
from galvi.fast.lanes.members.rows import Mask, Variable, larger
from galvi.kernels.nystrom.solve import FIXED_POINT_PASSES, IDLE


class Countdown(Judgement):
    """As `Judgement`, where the passes left are counted once a change is near round-off.

    left     passes left
    changes  the last ones, the newest first
    """

    def __init__(self, builder, row):
        super().__init__(builder)
        self.row = row
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
