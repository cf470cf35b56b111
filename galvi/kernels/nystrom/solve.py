"""Solves the stage equations of one step by fixed-point iteration or Newton's method.

Both start from stages Q (d, s) and leave accelerations a (d, s) from which the step is completed.
``tolerance`` bounds the estimated change of a further pass, relative to ``scale``.
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
    """The force of a system, as galvi.kernels.forces.accelerations takes it.

    Parameters
    ----------
    has_hessian
        whether functions[1] gives its derivative
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
TRUSTED = 0.3  # largest relative size of a first Newton correction near its start
LINEAR = 1e-8  # relative size of a second correction below which the force is linear
LOW_PART_CHANGE = 2.0**-16  # largest relative change of a pass whose slopes give low parts
IDLE = 3.0  # passes without a smaller change that mean round-off; twice as many, divergence
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
        last change and rate, smallest change, passes since; initially (inf, 1, inf, 0)

    Notes
    -----
    Errors oscillate as they shrink: a single small rate, or one change that did not shrink, is not
    conclusive.
    """
    last = history[0]
    rate = where(last < np.inf, change / last, 1.0)
    slower, less = larger(rate, history[1]), change < history[2]
    smallest, idle = where(less, change, history[2]), where(less, 0.0, history[3] + 1.0)
    history[0], history[1], history[2], history[3] = change, rate, smallest, idle
    enough = (change <= tolerance) | (change * slower <= tolerance * (1.0 - slower))
    at_rest = (idle >= IDLE) & (smallest <= ROUND_OFF_CHANGE)
    code = where(enough | at_rest, SOLVED, where(idle >= 2.0 * IDLE, DIVERGED, GOING))
    return where(change < np.inf, code, NOT_FINITE)


verdict = jit_inline(decide)


@generic
def gives_low_parts(change, tolerance):
    """Whether the slopes of a pass with this change are close enough to form low parts from.

    Those of the tables are 2^-53 of their sums, and from the slopes of a guess they may be wrong by
    any factor. So may the sizes to which changes are relative, where a guess gave them. They are
    not worth a pass where the tolerance exceeds them.
    """
    return (change < LOW_PART_CHANGE) & (tolerance <= EPSILON)


close_enough = jit_inline(gives_low_parts)


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
    """Iterate Q <- stages from a(Q) to the tolerance; returns a code."""
    moved, history = np.empty(Q.shape), np.empty(4)
    reset_history(history)
    for _passes in range(FIXED_POINT_PASSES):
        force_at_stages(force, Q, t, a)
        steps.place_stages(tableau, h, state, a, moved)
        counts[ITERATIONS] += 1
        counts[FORCES] += Q.shape[1]
        code = verdict(steps.largest_change(Q, moved, scale), tolerance, history)
        if code != GOING:
            return code
    return DIVERGED


@jit
def solve_newton(force, tableau, h, t, state, tolerance, scale, counts, a, Q):
    """Newton's method on the curve's coefficients; all passes but one must halve the last change.

    A first correction as large as the motion itself is accepted only when the second is negligible
    (a linear force): far from its start Newton's method may find another root.
    """
    (d, s), width = Q.shape, force.width
    x = np.empty((d, tableau.velocity_coefficients.size))
    steps.exact_coefficients(tableau, h, state, a, x)
    jacobian = np.empty((d, width, s))
    moved = np.empty((d, s))
    previous = np.inf
    slow = 0
    for passes in range(NEWTON_PASSES):
        force_at_stages(force, Q, t, a)
        extra = jacobians(
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
        counts[FORCES] += s + extra
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
        if passes == 1 and previous > TRUSTED and change > LINEAR:
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
        slow += 0 if halved else 1
        if slow >= 2:
            return DIVERGED
        previous = change
    return DIVERGED


@jit
def solve(force, tableau, h, t, state, solver, tolerance, streak, counts, a, Q):
    """Solve one step from the accelerations in a; returns (code, streak of Newton steps left)."""
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
