"""Solves the stage equations of one step by fixed-point iteration or Newton's method.

Both start from stages Q (d, s) and set the accelerations a (d, s) from which the step is completed.
They end when the estimated change of a further pass, relative to ``scale``, is at most
``tolerance``, or when changes are round-off.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, VECTOR, jit, jit_inline
from galvi.kernels.constants import EPSILON
from galvi.kernels.forces.accelerations import accelerations, jacobians
from galvi.kernels.lie.arithmetic import generic, larger, where
from galvi.kernels.nystrom import step as steps


class Force(NamedTuple):
    """The force of a system, for galvi.kernels.forces.accelerations.

    Attributes
    ----------
    has_hessian
        whether functions[1] computes the derivative of the force
    width
        size of the diagonal blocks of its derivative
    """

    kind: int
    functions: Any
    has_hessian: bool
    constants: Any
    inverse_mass: Any
    width: int


FORCE = types.Tuple((types.int64, types.int64[::1], types.boolean, VECTOR, MATRIX, types.int64))
AUTO, FIXED_POINT, NEWTON = 0, 1, 2
SOLVED, NOT_FINITE, DIVERGED, GOING = 0, 1, 2, 3

ITERATIONS, FORCES, HESSIANS, SOLVES, PAIRS = 0, 1, 2, 3, 4
ROUND_OFF_CHANGE = 1e-11  # relative change below which changes that no longer shrink are round-off
# Relative size of a first Newton correction above which the second must be negligible.
LARGEST_TRUSTED_CORRECTION = 0.3
LARGEST_LINEAR_CORRECTION = 1e-8  # largest relative size of a second correction that is negligible
LOW_PART_CHANGE = 2.0**-16  # relative change below which the slopes of a pass give low parts
# Passes without a smaller change after which changes are round-off; twice as many mean divergence.
IDLE_PASSES = 3.0
FIXED_POINT_PASSES = 200
NEWTON_PASSES = 30
NEWTON_STREAK = 16  # number of steps that start with Newton after it was needed


@generic
def decide(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass of fixed-point iteration; also in lanes.

    Parameters
    ----------
    change
        largest relative change of the pass
    history : array, shape (4,)
        last change and rate, smallest change, and passes since it; initially (inf, 1, inf, 0)

    Notes
    -----
    Errors oscillate as they shrink: a single small rate, or one change that did not shrink, is not
    conclusive.
    """
    last = history[0]
    rate = where(last < np.inf, change / last, 1.0)
    slower, is_smaller = larger(rate, history[1]), change < history[2]
    smallest, idle = where(is_smaller, change, history[2]), where(is_smaller, 0.0, history[3] + 1.0)
    history[0], history[1], history[2], history[3] = change, rate, smallest, idle
    enough = (change <= tolerance) | (change * slower <= tolerance * (1.0 - slower))
    at_rest = (idle >= IDLE_PASSES) & (smallest <= ROUND_OFF_CHANGE)
    code = where(enough | at_rest, SOLVED, where(idle >= 2.0 * IDLE_PASSES, DIVERGED, GOING))
    return where(change < np.inf, code, NOT_FINITE)


decide_inline = jit_inline(decide)


@generic
def gives_low_parts(change, tolerance):
    """Whether the slopes of a pass with this change are accurate enough for low parts.

    The sums with the low parts of the tables are 2^-53 of the sums. From the slopes of a guess they
    may be wrong by any factor, as may the sizes to which changes are relative. If the tolerance
    exceeds EPSILON, low parts are not worth a pass.
    """
    return (change < LOW_PART_CHANGE) & (tolerance <= EPSILON)


gives_low_parts_inline = jit_inline(gives_low_parts)


@generic
def reset_history(history):
    """Set history to its initial values."""
    history[0], history[1], history[2], history[3] = np.inf, 1.0, np.inf, 0.0


@jit_inline
def force_at_stages(force, Q, t, a):
    """a (d, s) <- accelerations at the stages Q."""
    accelerations(force.kind, force.functions, force.constants, force.inverse_mass, Q, t, a)


@jit
def solve_fixed_point(force, tableau, h, t, state, tolerance, scale, counts, a, Q):
    """Iterate Q <- stages from a(Q) until `decide` ends it; returns a code."""
    moved, history = np.empty(Q.shape), np.empty(4)
    reset_history(history)
    for _passes in range(FIXED_POINT_PASSES):
        force_at_stages(force, Q, t, a)
        steps.place_stages(tableau, h, state, a, moved)
        counts[ITERATIONS] += 1
        counts[FORCES] += Q.shape[1]
        code = decide_inline(steps.largest_change(Q, moved, scale), tolerance, history)
        if code != GOING:
            return code
    return DIVERGED


@jit
def solve_newton(force, tableau, h, t, state, tolerance, scale, counts, a, Q):
    """Newton's method on the curve's coefficients; returns a code.

    It has diverged when two passes have not halved the change of the pass before. After a first
    correction above LARGEST_TRUSTED_CORRECTION the second must be negligible, as for a linear
    force: far from its start Newton's method may find another root.
    """
    (d, s), width = Q.shape, force.width
    x = np.empty((d, tableau.velocity_coefficients.size))
    steps.exact_coefficients(tableau, h, state, a, x)
    jacobian = np.empty((d, width, s))
    moved = np.empty((d, s))
    previous = np.inf
    slow_passes = 0
    for passes in range(NEWTON_PASSES):
        force_at_stages(force, Q, t, a)
        force_evaluations = jacobians(
            force.kind,
            force.functions,
            force.has_hessian,
            force.constants,
            force.inverse_mass,
            Q,
            t,
            jacobian,
        )
        counts[ITERATIONS] += 1
        counts[FORCES] += s + force_evaluations
        counts[HESSIANS] += s if force.has_hessian else 0
        counts[SOLVES] += d // width
        finite = steps.all_finite(a)
        for i in range(d):
            finite = finite and steps.all_finite(jacobian[i])
        if not finite:
            return NOT_FINITE
        if not steps.newton_update(tableau, h, width, state, a, jacobian, x, moved):
            return DIVERGED
        change = steps.largest_change(Q, moved, scale)
        if not change < np.inf:
            return NOT_FINITE
        halved = change <= 0.5 * previous
        if (
            passes == 1
            and previous > LARGEST_TRUSTED_CORRECTION
            and change > LARGEST_LINEAR_CORRECTION
        ):
            return DIVERGED
        if change <= tolerance or (
            passes > 0
            and (
                (halved and change * change <= tolerance * previous)
                or (not halved and change <= ROUND_OFF_CHANGE)
            )
        ):
            force_at_stages(force, Q, t, a)
            counts[FORCES] += s
            return SOLVED
        slow_passes += 0 if halved else 1
        if slow_passes >= 2:
            return DIVERGED
        previous = change
    return DIVERGED


@jit
def solve(force, tableau, h, t, state, solver, tolerance, streak, counts, a, Q):
    """Solve one step from the accelerations in a.

    Returns a code, and the number of next steps that start with Newton's method.
    """
    steps.place_stages(tableau, h, state, a, Q)
    scale = np.empty(Q.shape[0])
    steps.measure_scale(h, force.width, state, scale)
    start = np.empty(a.shape)
    steps.copy_into(start, a)
    newton_first = solver == NEWTON or (solver == AUTO and streak > 0)
    code = DIVERGED
    for attempt in range(2):
        if newton_first == (attempt == 0):
            if solver != FIXED_POINT:
                code = solve_newton(force, tableau, h, t, state, tolerance, scale, counts, a, Q)
                if code == SOLVED:
                    return code, streak - 1 if newton_first else NEWTON_STREAK
        elif solver != NEWTON:
            code = solve_fixed_point(force, tableau, h, t, state, tolerance, scale, counts, a, Q)
            if code == SOLVED:
                return code, 0
        steps.copy_into(a, start)
        steps.place_stages(tableau, h, state, a, Q)
    return code, 0
