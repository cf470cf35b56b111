"""When the iteration of a law on a group is done: after the passes that its rate asks for.

Changes of about a rounding error say nothing of what is still missing, and a pass that is not
needed costs as much as any other. So the rate is taken from the changes above CLEAR, and the passes
that it asks for below are counted down.

history  (HISTORY,) of which the first four are those of galvi.kernels.nystrom.solve.decide; the
         last known change, times the rate at each pass; that rate; OVER changes, the newest first
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.lie.arithmetic import generic, in_kernels, larger, square_root, where
from galvi.kernels.nystrom import solve

HISTORY = 10  # numbers of history
REST, RATE, CHANGES = 4, 5, 6  # indices there
OVER = 4  # changes kept: errors oscillate, and the rate of convergence is a mean
FAR = 1e4  # changes so many times larger than the tolerance are not looked at closely
SOON = 1e-11  # relative change from which on the remaining passes are counted
CLEAR = 3e-15  # relative change that is not round-off
NOISE = 1e-13  # relative change that may be slow convergence, if PATIENCE passes lessen it
PATIENCE = 12.0


@generic
def begin_countdown(history):
    """Set history to its initial values."""
    solve.reset_history(history)
    history[REST], history[RATE] = np.inf, 0.5
    for k in range(CHANGES, CHANGES + OVER):
        history[k] = np.inf


@generic
def rate_of(change, last, second, first):
    """The mean rate since the first of OVER changes, or a careful guess from fewer; 0 if none."""
    guess = where(second < np.inf, larger(change / last, last / second), square_root(change / last))
    return where(first < np.inf, square_root(square_root(change / first)), guess)


def number_is_true(condition):
    """Whether a comparison of numbers is true."""
    return condition


@in_kernels(number_is_true)
def is_true(condition):
    """Whether a comparison of numbers is true; of lanes it is not known."""
    return not hasattr(condition, "select") and number_is_true(condition)


@generic
def count_down(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass with this largest relative change; also
    in lanes."""
    last, second, third, first = history[6], history[7], history[8], history[9]
    history[6], history[7], history[8], history[9] = change, last, second, third
    quick = (change > larger(FAR * tolerance, SOON)) & (change < 0.5 * last) & (last < np.inf)
    if is_true(quick):
        history[0] = change
        return solve.GOING
    rate, kept = history[RATE], (history[1], history[2], history[3], history[REST], history[RATE])
    code, rest = solve.decide(change, tolerance, history), history[REST] * rate
    left = rest * rate - tolerance * (1.0 - rate)  # above 0 where a further pass is needed
    solved, least, idle = code < solve.NOT_FINITE, history[2], history[3]
    # a rate may be small by chance, and some parts lag
    once_more = solved & (idle < solve.IDLE) & (tolerance < CLEAR) & (left > 0.0)
    patient = solved & (least > NOISE) & (idle >= solve.IDLE) & (idle < PATIENCE)
    rest, code = where(once_more, 0.0, rest), where(once_more | patient, solve.GOING, code)
    unknown = (change <= CLEAR) | (change >= SOON)
    if not is_true(unknown):
        new = rate_of(change, last, second, first)
        unknown = unknown | (new <= 0.0) | (new >= 1.0)
        left = where(unknown, left, change * new - tolerance * (1.0 - new))
        rest, rate = where(unknown, rest, change), where(unknown, rate, new)
    code = where((code > solve.DIVERGED) & (left <= 0.0), solve.SOLVED, code)
    history[REST], history[RATE] = rest, rate
    for k in range(5):
        history[k + 1] = where(quick, kept[k], history[k + 1])
    return where(quick, solve.GOING, code)


judged = jit_inline(count_down)
