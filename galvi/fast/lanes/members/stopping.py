"""The decisions of an iteration for eight members at once.

``terms_kept`` decides for them as galvi.kernels.nystrom.step.terms_to_extrapolate for one.
"""

from __future__ import annotations

import math

from numba.core import cgutils

from galvi.fast.lanes.members.rows import ALL, Mask, Variable, whole_number
from galvi.fast.lanes.values import Truth
from galvi.kernels.lie.arithmetic import larger, where
from galvi.kernels.nystrom.solve import DIVERGED, GOING, NOT_FINITE
from galvi.kernels.nystrom.step import EPSILON


class Judgement:
    """Which members of a step still iterate, and which failed.

    rule     begins a history of so many numbers, and judges a pass by it, in lanes
    active   members whose iteration goes on; what it has computed for the others is not changed
    code     how the iteration of each member ended, or GOING
    """

    def __init__(self, builder, rule):
        self.begin_history, self.decide, size = rule
        self.alive, self.active, self.code = Mask(builder), Mask(builder), Variable(builder)
        self.numbers = [Variable(builder) for _ in range(size)]

    def __getitem__(self, k):
        return self.numbers[k].lane

    def __setitem__(self, k, number):
        self.numbers[k].set(number)

    def begin(self, alive):
        """A step begins for the members that are alive."""
        self.alive.set(alive)
        self.active.set(alive)
        self.code.set(GOING)
        self.begin_history(self)

    def judge(self, change, tolerance):
        """After a pass with this largest relative change, a lane; tolerance is one too."""
        active = self.active.value
        code = where(active, self.decide(change, tolerance, self), self.code.lane)
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
