"""Rules that end the passes of a step, and the number of terms of the last step in its guess.

The numbers of one run, or of eight, are the lanes of a vector.

A pass yields the largest relative change. BY_CHANGES ends the passes by the rate of these changes,
see galvi.kernels.nystrom.solve.decide. BY_COUNTDOWN is for groups: changes near round-off do not
show how far the solution is, and a needless pass costs as much as any other. So the rate of
convergence is taken from changes above LEAST_CLEAR_CHANGE, and the passes that it implies from
there on are counted down.

The history of BY_COUNTDOWN has HISTORY numbers: the four of ``decide``; the last clear change,
multiplied by the rate in each pass since; that rate; and the last RATE_CHANGES changes, the newest
first.
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
ESTIMATED_CHANGE, RATE, CHANGES = 4, 5, 6  # indices there
RATE_CHANGES = 4  # number of changes for a mean rate of convergence, since errors oscillate
UNCHECKED_CHANGE = 1e4  # ratio to the tolerance above which a falling change needs no decision
COUNTED_BELOW = 1e-11  # relative change below which the remaining passes are counted
LEAST_CLEAR_CHANGE = 3e-15  # relative change above which it is more than round-off
# If the smallest relative change is above this, convergence may be slow: the iteration goes on for
# up to SLOW_PASSES passes without a smaller one.
SLOW_CONVERGENCE = 1e-13
SLOW_PASSES = 12.0


def begin_countdown(history):
    """Set a history of BY_COUNTDOWN to its initial values."""
    solve.reset_history(history)
    history[ESTIMATED_CHANGE], history[RATE] = np.inf, 0.5
    for k in range(CHANGES, CHANGES + RATE_CHANGES):
        history[k] = np.inf


def where_any(condition, compute, alternative):
    """``compute()`` where a condition is true, elsewhere the alternative; ``compute`` is not run if
    the condition is true for no run."""
    if not isinstance(condition, Truth):
        return compute() if condition else alternative
    builder, runs = condition.builder, condition.value.type.count
    chosen = Variable(builder, runs, alternative)
    with builder.if_then(condition.any):
        chosen.set(where(condition, compute(), alternative))
    return chosen.lane


def rate_of(change, last, second, first):
    """The rate by which changes shrink: the mean over RATE_CHANGES passes; an upper estimate if
    there were fewer, which is 0 after the first change."""
    guess = where(second < np.inf, larger(change / last, last / second), sqrt(change / last))
    return where(first < np.inf, sqrt(sqrt(change / first)), guess)


def count_down(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass with the largest relative change
    ``change``; updates the history."""
    last, second, third, first = (history[k] for k in range(CHANGES, CHANGES + RATE_CHANGES))
    for k, shifted in enumerate((change, last, second, third)):
        history[CHANGES + k] = shifted
    history_before = [history[k] for k in range(CHANGES)]
    is_early = (
        (change > larger(UNCHECKED_CHANGE * tolerance, COUNTED_BELOW))
        & (change < 0.5 * last)
        & (last < np.inf)
    )
    rate = history_before[RATE]
    code, remaining = (
        solve.decide(change, tolerance, history),
        history_before[ESTIMATED_CHANGE] * rate,
    )
    excess = remaining * rate - tolerance * (1.0 - rate)  # above 0 if a further pass is needed
    solved, smallest, idle = code < solve.NOT_FINITE, history[2], history[3]
    # A rate may be small by chance, and some components converge later than others.
    needs_pass = (
        solved & (idle < solve.IDLE_PASSES) & (tolerance < LEAST_CLEAR_CHANGE) & (excess > 0.0)
    )
    converges_slowly = (
        solved & (smallest > SLOW_CONVERGENCE) & (idle >= solve.IDLE_PASSES) & (idle < SLOW_PASSES)
    )
    remaining, code = (
        where(needs_pass, 0.0, remaining),
        where(needs_pass | converges_slowly, solve.GOING, code),
    )
    is_clear = (change > LEAST_CLEAR_CHANGE) & (change < COUNTED_BELOW)
    new_rate = where_any(is_clear, lambda: rate_of(change, last, second, first), 0.0)
    has_no_rate = (new_rate <= 0.0) | (new_rate >= 1.0)
    excess = where(has_no_rate, excess, change * new_rate - tolerance * (1.0 - new_rate))
    remaining, rate = where(has_no_rate, remaining, change), where(has_no_rate, rate, new_rate)
    code = where((code > solve.DIVERGED) & (excess <= 0.0), solve.SOLVED, code)
    history[ESTIMATED_CHANGE], history[RATE] = remaining, rate
    for k, number in enumerate(history_before[1:], 1):
        history[k] = where(is_early, number, history[k])
    return where(is_early, solve.GOING, code)


BY_CHANGES = solve.reset_history, solve.decide, 4
BY_COUNTDOWN = begin_countdown, count_down, HISTORY


class Mask:
    """A variable that holds one truth value for each run; initially true."""

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
    """A variable that holds one number for each run."""

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
    """The state of the iteration of each run of a step: active, solved or failed.

    Parameters
    ----------
    rule
        (begin, decide, size): ``begin`` initialises a history of ``size`` numbers, from which
        ``decide`` returns a code after each pass

    Attributes
    ----------
    alive
        runs that take this step
    active
        runs whose iteration goes on; the numbers of the others do not change
    code
        the code of the iteration of each run; GOING before it ends
    settled
        runs of which a pass changed so little that its slopes give low parts; and runs that are
        not alive
    settles
        runs of which the last pass was the first of this kind; their iteration goes on
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
        """Reset all for a step of the runs ``alive``."""
        self.alive.set(alive)
        self.active.set(alive)
        self.settled.set(~alive)
        self.settles.set(alive & ~alive)  # none
        self.code.set(GOING)
        self.begin_history(self)

    def update(self, change, tolerance):
        """Update codes and masks after a pass whose largest relative change is ``change``, a
        lane."""
        active = self.active.value
        settles = active & ~self.settled.value & gives_low_parts(change, tolerance)
        self.settles.set(settles)
        self.settled.set(self.settled.value | settles)
        code = where(active, self.decide(change, tolerance, self), self.code.lane)
        code = where(settles, GOING, code)
        self.code.set(code)
        self.active.set(active & (code > DIVERGED))

    def end(self, finite, within):
        """Update the codes after the last pass: NOT_FINITE for a solved step that is not
        ``finite``, DIVERGED for one that is not ``within`` reach or whose iteration has not ended.

        Returns the runs whose step succeeded, and those whose step failed.
        """
        code = self.code.lane
        code = where((code < NOT_FINITE) & ~finite, NOT_FINITE, code)
        code = where(((code < NOT_FINITE) & ~within) | (code > DIVERGED), DIVERGED, code)
        self.code.set(code)
        alive = self.alive.value
        return alive & (code < NOT_FINITE), alive & (code >= NOT_FINITE)


def terms_of_guess(rows, size):
    """The number of Legendre terms to extrapolate, as
    galvi.kernels.nystrom.step.terms_to_extrapolate.

    Parameters
    ----------
    rows
        a layout
    size
        (index) -> the magnitude of a coefficient, for each run
    """
    builder, row, count, growth = rows.builder, rows.row, rows.terms, rows.real
    largest, best, terms = rows.variable(), rows.variable(math.inf), rows.variable(1.0)
    may_continue = Mask(builder, rows.runs)
    with cgutils.for_range(builder, count, intp=row) as loop:
        largest.set(larger(size(loop.index), largest.lane))
    second, last = builder.sub(count, row(2)), builder.sub(count, row(1))
    single = builder.icmp_unsigned("<", count, row(2))
    second = builder.select(single, row(0), second)
    with cgutils.for_range(builder, count, intp=row) as loop:
        term = size(loop.index) * growth(loop.index)
        first = builder.icmp_unsigned("==", loop.index, row(0))
        is_small = term <= 4.0 * largest.lane
        is_first_or_small = builder.select(
            first, everywhere(is_small.value.type, 1), is_small.value
        )
        may_continue.set(may_continue.value & Truth(builder, is_first_or_small))
        cost = EPSILON * largest.lane * growth(loop.index)
        kept_count = builder.add(loop.index, row(1))
        first = builder.select(builder.icmp_unsigned("<", kept_count, second), kept_count, second)
        after = builder.add(first, row(1))
        after = builder.select(builder.icmp_unsigned("<", after, last), after, last)
        for index in (first, after):
            cost = larger(size(index) * growth(index), cost)
        is_better = may_continue.value & (cost <= best.lane)
        best.set(cost.where(is_better, best.lane))
        terms.set(rows.integer_as_real(kept_count).where(is_better, terms.lane))
    return terms.lane
