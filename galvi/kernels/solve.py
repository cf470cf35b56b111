"""The stage equations of one step: fixed-point iteration, Newton's method, and the choice.

Both start from stages Q (d, s) and leave accelerations a (d, s) from which the step is completed.
``tolerance`` bounds the estimated change, relative to ``scale``, that another pass would make.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.accelerations import accelerations
from galvi.kernels.jacobians import jacobians
from galvi.kernels.jit import jit
from galvi.kernels.step import (
    all_finite,
    copy_into,
    curve_coefficients,
    largest_change,
    measure_scale,
    newton_update,
    place_stages,
)

AUTO, FIXED_POINT, NEWTON = 0, 1, 2
SOLVED, NOT_FINITE, DIVERGED = 0, 1, 2

ITERATIONS, FORCES, HESSIANS, SOLVES = 0, 1, 2, 3
FLOOR = 1e-11  # a change that no longer shrinks is round-off below this, divergence above
FIXED_POINT_PASSES = 200
NEWTON_PASSES = 30
NEWTON_STREAK = 16  # steps that start with Newton after it was needed once


@jit
def settled(change, previous, stall, tolerance):
    """Whether another pass would change nothing that matters.

    A change above ``stall`` times the last one is round-off when it is small enough.
    """
    if change <= tolerance:
        return True
    if change >= stall * previous:
        return change <= FLOOR
    rate = change / previous
    return change * rate <= tolerance * (1.0 - rate)


@jit
def solve_fixed_point(functions, constants, inverse_mass, tableau, h, t, state, tolerance, patience,
                      scale, counts, a, Q):  # fmt: skip
    """Q <- stages of a(Q), until settled; gives up when it cannot settle within ``patience``."""
    kind, law, law_jacobian, gradient, timed_gradient, hessian, timed_hessian = functions
    moved = np.empty(Q.shape)
    previous = np.inf
    growing = 0
    for passes in range(patience):
        accelerations(kind, law, gradient, timed_gradient, constants, inverse_mass, Q, t, a)
        place_stages(tableau, h, state, a, moved)
        change = largest_change(Q, moved, scale)
        counts[ITERATIONS] += 1
        counts[FORCES] += Q.shape[1]
        if not change < np.inf:
            return NOT_FINITE
        if passes > 0:
            if settled(change, previous, 1.0, tolerance):
                return SOLVED
            growing = growing + 1 if change >= previous else 0
            if growing >= 4 or change > 1e6:
                return DIVERGED
        elif change <= tolerance:
            return SOLVED
        previous = change
    return DIVERGED


@jit
def solve_newton(functions, has_hessian, constants, inverse_mass, width, tableau, h, t, state,
                 tolerance, scale, counts, a, Q):  # fmt: skip
    """Newton on the curve's coefficients; all passes but one must halve the last change."""
    kind, law, law_jacobian, gradient, timed_gradient, hessian, timed_hessian = functions
    d, s = Q.shape
    x = np.empty((d, tableau[5].size))
    curve_coefficients(tableau, h, state, a, x)
    jacobian = np.empty((d, width, s))
    moved = np.empty((d, s))
    previous = np.inf
    slow = 0
    for passes in range(NEWTON_PASSES):
        accelerations(kind, law, gradient, timed_gradient, constants, inverse_mass, Q, t, a)
        extra = jacobians(functions, has_hessian, constants, inverse_mass, Q, t, jacobian)
        counts[ITERATIONS] += 1
        counts[FORCES] += s + extra
        counts[HESSIANS] += s if has_hessian else 0
        counts[SOLVES] += d // width
        if not (all_finite(a) and all_finite(jacobian.reshape(d, width * s))):
            return NOT_FINITE
        newton_update(tableau, h, width, state, a, jacobian, x, moved)
        change = largest_change(Q, moved, scale)
        if not change < np.inf:
            return NOT_FINITE
        if passes > 0 and settled(change, previous, 0.5, tolerance):
            accelerations(kind, law, gradient, timed_gradient, constants, inverse_mass, Q, t, a)
            counts[FORCES] += s
            return SOLVED
        slow += 1 if change > 0.5 * previous else 0
        if slow >= 2:
            return DIVERGED
        previous = change
    return DIVERGED


@jit
def solve(functions, has_hessian, constants, inverse_mass, width, tableau, h, t, state, solver,
          tolerance, streak, counts, a, Q):  # fmt: skip
    """Solve one step from the accelerations in a; returns (code, streak of Newton steps left)."""
    place_stages(tableau, h, state, a, Q)
    scale = np.empty(Q.shape[0])
    measure_scale(Q, width, scale)
    start = np.empty(a.shape)
    copy_into(start, a)
    newton_first = solver == NEWTON or (solver == AUTO and streak > 0)
    code = DIVERGED
    for attempt in range(2):
        if newton_first == (attempt == 0):
            if solver != FIXED_POINT:
                code = solve_newton(functions, has_hessian, constants, inverse_mass, width, tableau,
                                    h, t, state, tolerance, scale, counts, a, Q)  # fmt: skip
                if code == SOLVED:
                    return code, streak - 1 if newton_first else NEWTON_STREAK
        elif solver != NEWTON:
            patience = FIXED_POINT_PASSES
            code = solve_fixed_point(functions, constants, inverse_mass, tableau, h, t, state,
                                     tolerance, patience, scale, counts, a, Q)  # fmt: skip
            if code == SOLVED:
                return code, 0
        copy_into(a, start)
        place_stages(tableau, h, state, a, Q)
    return code, 0
