"""When the passes of a step end, and how many terms of the last step its guess keeps.

For one run or eight, whose numbers lie in the lanes of a vector, one of each run.

A pass gives the largest relative change. BY_CHANGES ends the passes from the rate of changes, see
galvi.kernels.nystrom.solve.decide. BY_COUNTDOWN is for groups: changes of about a rounding error
say nothing of what is still missing, and a pass that is not needed costs as much as any other. So
the rate is taken from the changes above CLEAR, and the passes that it asks for below are counted
down.

The history of BY_COUNTDOWN is HISTORY numbers, of which the first four are those of ``decide``;
the last change above CLEAR times the rate of each pass since; that rate; RATE_CHANGES changes,
the newest first.
"""

from __future__ import annotations

import math

import numpy as np
from llvmlite import ir

from galvi.kernels.compile.internals import cgutils
from galvi.kernels.constants import EPSILON
from galvi.kernels.lie.arithmetic import larger, where
from galvi.kernels.lie.elementary import sqrt
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.solve import DIVERGED, GOING, NOT_FINITE, gives_low_parts
from galvi.lanes.values import Lane, Truth
from galvi.lanes.vectors import DOUBLE, everywhere

HISTORY = 10  # numbers of history
REST_CHANGE, RATE, CHANGES = 4, 5, 6  # indices there
RATE_CHANGES = 4  # changes kept: errors oscillate, and the rate of convergence is a mean
FAR_FROM_SOLVED = 1e4  # changes so many times larger than the tolerance are not looked at closely
COUNTED_BELOW = 1e-11  # relative change from which on the remaining passes are counted
CLEAR = 3e-15  # relative change that is not round-off
# Relative change that may be slow convergence, if SLOW_PASSES passes lessen it.
SLOW_CONVERGENCE = 1e-13
SLOW_PASSES = 12.0  # without a smaller change, after which convergence has ended


def begin_countdown(history):
    solve.reset_history(history)
    history[REST_CHANGE], history[RATE] = np.inf, 0.5
    for k in range(CHANGES, CHANGES + RATE_CHANGES):
        history[k] = np.inf


def where_any(condition, compute, alternative):
    """``compute()`` where a condition is true, elsewhere the alternative; not computed where it is
    true of no run."""
    if not isinstance(condition, Truth):
        return compute() if condition else alternative
    builder, runs = condition.builder, condition.value.type.count
    chosen = Variable(builder, runs, alternative)
    with builder.if_then(condition.any):
        chosen.set(where(condition, compute(), alternative))
    return chosen.lane


def rate_of(change, last, second, first):
    """The mean rate over RATE_CHANGES changes; from fewer an upper estimate, 0 for none."""
    guess = where(second < np.inf, larger(change / last, last / second), sqrt(change / last))
    return where(first < np.inf, sqrt(sqrt(change / first)), guess)


def count_down(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass with this largest relative change."""
    last, second, third, first = (history[k] for k in range(CHANGES, CHANGES + RATE_CHANGES))
    for k, shifted in enumerate((change, last, second, third)):
        history[CHANGES + k] = shifted
    old = [history[k] for k in range(CHANGES)]
    quick = (
        (change > larger(FAR_FROM_SOLVED * tolerance, COUNTED_BELOW))
        & (change < 0.5 * last)
        & (last < np.inf)
    )
    rate = old[RATE]
    code, remaining = solve.decide(change, tolerance, history), old[REST_CHANGE] * rate
    left = remaining * rate - tolerance * (1.0 - rate)  # above 0 where a further pass is needed
    solved, smallest, idle = code < solve.NOT_FINITE, history[2], history[3]
    # a rate may be small by chance, and some parts lag
    once_more = solved & (idle < solve.IDLE) & (tolerance < CLEAR) & (left > 0.0)
    patient = solved & (smallest > SLOW_CONVERGENCE) & (idle >= solve.IDLE) & (idle < SLOW_PASSES)
    remaining, code = (
        where(once_more, 0.0, remaining),
        where(once_more | patient, solve.GOING, code),
    )
    clear = (change > CLEAR) & (change < COUNTED_BELOW)
    new = where_any(clear, lambda: rate_of(change, last, second, first), 0.0)
    unknown = (new <= 0.0) | (new >= 1.0)
    left = where(unknown, left, change * new - tolerance * (1.0 - new))
    remaining, rate = where(unknown, remaining, change), where(unknown, rate, new)
    code = where((code > solve.DIVERGED) & (left <= 0.0), solve.SOLVED, code)
    history[REST_CHANGE], history[RATE] = remaining, rate
    for k, number in enumerate(old[1:], 1):
        history[k] = where(quick, number, history[k])
    return where(quick, solve.GOING, code)


BY_CHANGES = solve.reset_history, solve.decide, 4
BY_COUNTDOWN = begin_countdown, count_down, HISTORY


class Mask:
    """A variable, one truth value a run; initially true."""

    def __init__(self, builder, runs):
        self.builder, kind = builder, ir.VectorType(ir.IntType(1), runs)
        self.pointer = cgutils.alloca_once(builder, kind)
        builder.store(everywhere(kind, 1), self.pointer)

    @property
    def value(self):
        return Truth(self.builder, self.builder.load(self.pointer))

    def set(self, truth):
        self.builder.store(truth.value, self.pointer)


class Variable:
    """A variable, one number a run."""

    def __init__(self, builder, runs, number=0.0):
        self.builder, self.kind = builder, ir.VectorType(DOUBLE, runs)
        self.pointer = cgutils.alloca_once(builder, self.kind)
        self.set(number)

    @property
    def lane(self):
        """The current numbers; their operations are not fused."""
        return Lane(self.builder, self.builder.load(self.pointer), ())

    def set(self, number):
        """Store a lane, or one number for all runs."""
        zero = Lane(self.builder, everywhere(self.kind, 0.0), ())
        self.builder.store(zero.same(number).value, self.pointer)


class Convergence:
    """Which runs of a step still iterate, and which failed.

    Parameters
    ----------
    rule
        (begin, decide, size): functions that initialise a history of ``size`` numbers, and decide
        by it after a pass whether the iteration ends

    Attributes
    ----------
    active
        runs whose iteration goes on; the numbers of the others stay
    code
        how the iteration of each run ended, or GOING
    settled
        runs of which a pass changed little enough that its slopes give low parts
    settles
        runs whose last pass was the first such one; they iterate on
    """

    def __init__(self, builder, rule, runs):
        self.begin_history, self.decide, size = rule
        self.alive, self.active, self.settled, self.settles = (
            Mask(builder, runs) for _ in range(4)
        )
        self.code, *self.numbers = (Variable(builder, runs) for _ in range(size + 1))

    def __getitem__(self, k):
        return self.numbers[k].lane

    def __setitem__(self, k, number):
        self.numbers[k].set(number)

    def begin(self, alive):
        """A step begins for the runs that are alive."""
        self.alive.set(alive)
        self.active.set(alive)
        self.settled.set(~alive)
        self.settles.set(alive & ~alive)  # none
        self.code.set(GOING)
        self.begin_history(self)

    def judge(self, change, tolerance):
        """Update all after a pass whose largest relative change is ``change``; lanes."""
        active = self.active.value
        settles = active & ~self.settled.value & gives_low_parts(change, tolerance)
        self.settles.set(settles)
        self.settled.set(self.settled.value | settles)
        code = where(active, self.decide(change, tolerance, self), self.code.lane)
        code = where(settles, GOING, code)
        self.code.set(code)
        self.active.set(active & (code > DIVERGED))

    def end(self, finite, within):
        """Update the codes after the last pass, where the end state is finite, and within reach.

        Returns the runs whose step succeeded, and those whose step failed.
        """
        code = self.code.lane
        code = where((code < NOT_FINITE) & ~finite, NOT_FINITE, code)
        code = where(((code < NOT_FINITE) & ~within) | (code > DIVERGED), DIVERGED, code)
        self.code.set(code)
        alive = self.alive.value
        return alive & (code < NOT_FINITE), alive & (code >= NOT_FINITE)


def terms_kept(rows, size):
    """How many Legendre terms to extrapolate, as galvi.kernels.nystrom.step.terms_to_extrapolate.

    Parameters
    ----------
    rows
        a layout
    size
        (index) -> the magnitude of a term, for each run
    """
    builder, row, count, growth = rows.builder, rows.row, rows.terms, rows.real
    largest, best, terms = rows.variable(), rows.variable(math.inf), rows.variable(1.0)
    open_ = Mask(builder, rows.runs)
    with cgutils.for_range(builder, count, intp=row) as loop:
        largest.set(larger(size(loop.index), largest.lane))
    second, last = builder.sub(count, row(2)), builder.sub(count, row(1))
    single = builder.icmp_unsigned("<", count, row(2))
    second = builder.select(single, row(0), second)
    with cgutils.for_range(builder, count, intp=row) as loop:
        term = size(loop.index) * growth(loop.index)
        first = builder.icmp_unsigned("==", loop.index, row(0))
        small = term <= 4.0 * largest.lane
        still = builder.select(first, everywhere(small.value.type, 1), small.value)
        open_.set(open_.value & Truth(builder, still))
        cost = EPSILON * largest.lane * growth(loop.index)
        kept_count = builder.add(loop.index, row(1))
        first = builder.select(builder.icmp_unsigned("<", kept_count, second), kept_count, second)
        after = builder.add(first, row(1))
        after = builder.select(builder.icmp_unsigned("<", after, last), after, last)
        for index in (first, after):
            cost = larger(size(index) * growth(index), cost)
        better = open_.value & (cost <= best.lane)
        best.set(cost.where(better, best.lane))
        terms.set(rows.whole_number(kept_count).where(better, terms.lane))
    return terms.lane
