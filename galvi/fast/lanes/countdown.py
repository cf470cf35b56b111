"""When the iteration of a law on a group is done: after the passes that its rate asks for.

Changes of about a rounding error say nothing of what is still missing, and a pass that is not
needed costs as much as any other. So the rate is taken from the changes above CLEAR, and the passes
that it asks for below are counted down.

history  (9,) of which the first four are those of galvi.kernels.nystrom.solve.verdict; the passes
         left, and the last changes, the newest first
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.nystrom.solve import (
    FIXED_POINT_PASSES,
    GOING,
    IDLE,
    SOLVED,
    reset_history,
    verdict,
)

LEFT, CHANGES = 4, 5  # indices in history
OVER = 4  # changes kept: errors oscillate, and the rate of convergence is a mean
FAR = 1e4  # changes so many times larger than the tolerance are not looked at closely
SOON = 1e-11  # relative change from which on the remaining passes are counted
CLEAR = 3e-15  # relative change that is not round-off
NOISE = 1e-13  # relative change that may be slow convergence, if PATIENCE passes lessen it
PATIENCE = 12.0
MANY = 40


@jit_inline
def begin_countdown(history):
    """Set history to its initial values."""
    reset_history(history)
    history[LEFT] = FIXED_POINT_PASSES
    history[CHANGES : CHANGES + OVER] = np.inf


@jit_inline
def remaining(change, rate, tolerance):
    """How many further passes leave a change of at most the tolerance; MANY if very many."""
    count = 0
    while count < MANY and change * rate > tolerance * (1.0 - rate):
        change *= rate
        count += 1
    return count


@jit_inline
def rate_of(change, last, second, first):
    """The mean rate since the first of OVER changes, or a careful guess from fewer; 0 if none."""
    if first < np.inf:
        return np.sqrt(np.sqrt(change / first))
    if second < np.inf:
        return max(change / last, last / second)
    return np.sqrt(change / last)


@jit_inline
def judged(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass with this largest relative change."""
    last, second, third, first = history[5], history[6], history[7], history[8]
    history[5], history[6], history[7], history[8] = change, last, second, third
    if max(SOON, FAR * tolerance) < change < 0.5 * last < np.inf:
        history[0] = change
        return GOING
    history[LEFT] -= 1.0
    code = verdict(change, tolerance, history)
    if code == SOLVED and history[3] < IDLE and tolerance < CLEAR and history[LEFT] > 0.0:
        history[LEFT], code = 1.0, GOING  # a rate may be small by chance, and some parts lag
    if code == SOLVED and history[2] > NOISE and IDLE <= history[3] < PATIENCE:
        code = GOING
    if CLEAR < change < SOON:
        rate = rate_of(change, last, second, first)
        if 0.0 < rate < 1.0:
            history[LEFT] = remaining(change, rate, tolerance)
    return SOLVED if code == GOING and history[LEFT] <= 0.0 else code
