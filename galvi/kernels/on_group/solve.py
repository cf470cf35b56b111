"""Newton's iteration for one step on a group; notation of galvi.kernels.on_group.stages."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from galvi.kernels.compile.jit import jit, jit_noalloc
from galvi.kernels.constants import LEAST_NORMAL
from galvi.kernels.lie import product
from galvi.kernels.lie.product import is_flat, position_scale
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.step import copy_into
from galvi.kernels.on_group import scale as scales
from galvi.kernels.on_group.derivative import derivative, factor, substitute
from galvi.kernels.on_group.stages import new_scratch, place_curve, residual, stage_slopes

STEP_PASSES = 60  # most of a step's iteration
DERIVATIVE_CONTRACTION = 0.2  # contraction factor above which the derivative is recomputed
NEARLY_SOLVED = 1e-10  # relative change below which neither that nor damping is done
MEASURED = 4  # most derivatives at the start of a step, each with scales from the one before
SHORTEST = 2.0**-24  # smallest share of a correction that is tried
GUESS_CORRECTIONS = 4  # corrections of an initial guess by the chart's tangent map


@jit_noalloc
def coefficients(basis, h, rates, x):
    """x (d, m) <- coefficients of the curve nearest to rates xi' (d, s) at the stages."""
    first, projection = basis.first, basis.projection
    x[:, :] = 0.0
    for a in range(x.shape[0]):
        for i in range(first[a + 1] - first[a]):
            total = 0.0
            for j in range(rates.shape[1]):
                total += projection[i, j] * rates[a, j]
            x[a, i] = h * total


@jit
def guess_curve(layout, chart, basis, h, velocities, x):
    """x <- coefficients of a curve with about these velocities (d, s) at the stages.

    xi' = T(xi)^-1 velocity, with a few iterations for xi.
    """
    if is_flat(layout):
        coefficients(basis, h, velocities, x)
        return
    d, s = velocities.shape
    coordinates, rate = np.zeros((d, s)), np.empty((d, s))
    xi, velocity, solved = np.empty(d), np.empty(d), np.empty(d)
    rates = velocities.copy()
    for _pull in range(GUESS_CORRECTIONS):
        coefficients(basis, h, rates, x)
        place_curve(basis, h, x, coordinates, rate)
        for j in range(s):
            for a in range(d):
                xi[a], velocity[a] = coordinates[a, j], velocities[a, j]
            product.rate(layout, chart, xi, velocity, solved)
            for a in range(d):
                rates[a, j] = solved[a]


class Newton(NamedTuple):
    """The state of an iteration.

    Attributes
    ----------
    matrix, pivots
        factors of the derivative, and ``right``, scratch for a right-hand side
    R, ahead, step : array, shape (d, m)
        residual, the correction from here, and the last one that was taken
    to_place, to_rate : array, shape (d, s)
        of the correction from here
    scale, sizes : array, shape (d,)
        see galvi.kernels.on_group.scale; ``sizes`` is scratch
    history : array, shape (4,)
        see galvi.kernels.nystrom.solve
    """

    matrix: Any
    pivots: Any
    right: Any
    R: Any
    ahead: Any
    step: Any
    to_place: Any
    to_rate: Any
    scale: Any
    sizes: Any
    history: Any


@jit
def new_iteration(unknowns, d, m, s):
    """A ``Newton`` for so many unknowns."""
    return Newton(
        np.empty((unknowns, unknowns)),
        np.empty(unknowns, np.int64),
        np.empty(unknowns),
        np.empty((d, m)),
        np.empty((d, m)),
        np.empty((d, m)),
        np.empty((d, s)),
        np.empty((d, s)),
        np.empty(d),
        np.empty(d),
        np.empty(4),
    )


@jit_noalloc
def correct(basis, h, newton):
    """The correction from here <- -matrix^-1 R, and its curve."""
    R, ahead, first, flat = newton.R, newton.ahead, basis.first, newton.right
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            flat[first[a] + i] = -R[a, i]
    substitute(newton.matrix, newton.pivots, flat)
    ahead[:, :] = 0.0
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            ahead[a, i] = flat[first[a] + i]
    place_curve(basis, h, ahead, newton.to_place, newton.to_rate)


@jit_noalloc
def add(x, factor_, step):
    """x <- x + factor_ step, (d, m)."""
    for a in range(x.shape[0]):
        for i in range(x.shape[1]):
            x[a, i] += factor_ * step[a, i]


@jit_noalloc
def differentiate(law, method, scratch, start, curve, newton, rounds, counts):
    """Form the derivative here, and the correction with it; whether it is regular.

    Parameters
    ----------
    rounds
        how often its scales may be taken from the correction before. That of a motion from rest is
        known only after the first one
    """
    d, s = curve.coordinates.shape
    scale, sizes, h = newton.scale, newton.sizes, start.h
    rate_scale = scales.largest(curve.rate)
    at_rest = rate_scale == 0.0
    for _round in range(rounds):
        size = 0.0
        for a in range(d):
            sizes[a] = scale[a] if scale[a] > 0.0 else 1.0
            size = max(size, sizes[a])
        rate_scale = rate_scale if rate_scale > 0.0 else size / abs(h)
        rate_scale = max(rate_scale, LEAST_NORMAL)
        derivative(law, method, scratch, start, curve, sizes, rate_scale, newton.matrix)
        counts[solve.FORCES] += 2 * d * s
        counts[solve.SOLVES] += 1
        if not factor(newton.matrix, newton.pivots):
            return False
        correct(method.basis, h, newton)
        largest_rate = scales.largest(newton.to_rate)
        if not largest_rate > scales.BAD_SCALE_RATIO * rate_scale and not (
            at_rest and 0.0 < scales.BAD_SCALE_RATIO * largest_rate < rate_scale
        ):
            break
        scales.grow_scale(method.layout, newton.to_place, newton.to_rate, h, scale)
        rate_scale = largest_rate
    scales.grow_scale(method.layout, newton.to_place, newton.to_rate, h, scale)
    return True


@jit_noalloc
def verdict(method, h, curve, change, tolerance, history):
    """Whether the iteration has ended with a relative change, as a code.

    What changes that no longer shrink may be, to be round-off, grows with the coordinates of
    rotations near the chart's limit.
    """
    code = solve.decide_inline(change, tolerance, history)
    if code != solve.NOT_FINITE and history[3] >= solve.IDLE_PASSES:
        amplified = scales.amplification(method.layout, curve.coordinates, curve.rate, h)
        if history[2] <= solve.ROUND_OFF_CHANGE * amplified and scales.is_resolved(
            method.basis.analysis, curve.velocities
        ):
            code = solve.SOLVED
    return code


@jit
def solve_group(law, method, start, curve, tolerance, allow_damping, counts):
    """The curve's x <- the solution nearest to it, with its forces and velocities. Returns a code.

    The derivative is reused while the iteration contracts well. If a correction is larger than the
    one before, the latter is undone and repeated with a new derivative or halved (natural
    monotonicity test: Deuflhard, Newton Methods for Nonlinear Problems, 3.3). Far from a good
    guess, damping may find another root, whose rotation exceeds the chart, so it is used only if
    ``allow_damping``.
    """
    layout, chart, basis = method.layout, method.chart, method.basis
    h, g = start.h, start.g
    x, coordinates, rate = curve.x, curve.coordinates, curve.rate
    (d, m), s = x.shape, coordinates.shape[1]
    newton, scratch = new_iteration(basis.first[d], d, m, s), new_scratch(d, g.size, m)
    now, scale, history = np.empty(d), newton.scale, newton.history
    solve.reset_history(history)
    formed = at_start = False  # whether a derivative exists, and whether at step's start
    last, share = np.inf, 1.0
    place_curve(basis, h, x, coordinates, rate)
    position_scale(layout, g, scale)
    scales.grow_scale(layout, coordinates, rate, h, scale)
    for passes in range(STEP_PASSES):
        stage_slopes(law, layout, chart, scratch, start, curve)
        residual(method, scratch, start, curve, newton.R)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += s
        change = np.inf
        if formed:
            correct(basis, h, newton)
            change = scales.relative_size(
                newton.to_place, newton.to_rate, h, scale, scales.largest(rate)
            )
            nearly_solved = NEARLY_SOLVED * scales.amplification(layout, coordinates, rate, h)
            if allow_damping and not change <= last and last > nearly_solved:
                add(x, -share, newton.step)
                formed, share = at_start, 0.5 * share
                if at_start:
                    add(x, share, newton.step)
                if share < SHORTEST:
                    return solve.DIVERGED if change < np.inf else solve.NOT_FINITE
                place_curve(basis, h, x, coordinates, rate)
                continue
            formed = change <= DERIVATIVE_CONTRACTION * last or change < nearly_solved
        at_start = not formed
        if not formed:
            rounds = MEASURED if passes == 0 else 1
            if not differentiate(law, method, scratch, start, curve, newton, rounds, counts):
                return solve.NOT_FINITE
            change = scales.relative_size(
                newton.to_place, newton.to_rate, h, scale, scales.largest(rate)
            )
            formed = True
        copy_into(newton.step, newton.ahead)
        add(x, 1.0, newton.step)
        last, share = change, 1.0
        place_curve(basis, h, x, coordinates, rate)
        if not scales.largest(coordinates) < np.inf:
            return solve.NOT_FINITE
        code = verdict(method, h, curve, change, tolerance, history)
        if code == solve.SOLVED:
            position_scale(layout, g, now)
            scales.grow_scale(layout, coordinates, rate, h, now)
            if not scales.shrink_scale(now, scale):
                stage_slopes(law, layout, chart, scratch, start, curve)
                counts[solve.FORCES] += s
                return solve.SOLVED
            solve.reset_history(history)
            last = np.inf
        elif code != solve.GOING:
            return solve.DIVERGED if code != solve.NOT_FINITE else code
    return solve.DIVERGED
