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

MAX_PASSES = 60  # of the iteration of one time step
DERIVATIVE_CONTRACTION = 0.2  # contraction factor above which the derivative is recomputed
# Relative change, times the amplification near a chart's limit, below which the derivative is kept;
# after such a change nothing is damped.
NEARLY_SOLVED = 1e-10
MAX_FIRST_DERIVATIVES = 4  # at the first pass, each with scales from the correction before it
SMALLEST_SHARE = 2.0**-24  # of a correction, that damping tries
GUESS_CORRECTIONS = 3  # of the rates of an initial guess, by the chart's tangent map


@jit_noalloc
def coefficients(basis, h, rates, x):
    """x (d, m) <- the least-squares fit, weighted by b, of the curve to rates xi' (d, s)."""
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

    xi' = T(xi)^-1 velocity, iterated GUESS_CORRECTIONS times for xi.
    """
    if is_flat(layout):
        coefficients(basis, h, velocities, x)
        return
    d, s = velocities.shape
    coordinates, rate = np.zeros((d, s)), np.empty((d, s))
    xi, velocity, stage_rate = np.empty(d), np.empty(d), np.empty(d)
    rates = velocities.copy()
    for _ in range(GUESS_CORRECTIONS):
        coefficients(basis, h, rates, x)
        place_curve(basis, h, x, coordinates, rate)
        for j in range(s):
            for a in range(d):
                xi[a], velocity[a] = coordinates[a, j], velocities[a, j]
            product.rate(layout, chart, xi, velocity, stage_rate)
            for a in range(d):
                rates[a, j] = stage_rate[a]
    coefficients(basis, h, rates, x)


class Newton(NamedTuple):
    """The state of Newton's iteration for n unknowns.

    Attributes
    ----------
    matrix, pivots : array, shape (n, n) and (n,)
        LU factors of the derivative dR/dx
    rhs : array, shape (n,)
        scratch for a right-hand side
    R, correction, last_correction : array, shape (d, m)
        residual, the correction from the present x, and the last one that was taken
    xi_change, rate_change : array, shape (d, s)
        changes of xi and xi' at the stages by ``correction``
    scale, sizes : array, shape (d,)
        see galvi.kernels.on_group.scale; ``sizes`` is scratch
    history : array, shape (4,)
        see galvi.kernels.nystrom.solve
    """

    matrix: Any
    pivots: Any
    rhs: Any
    R: Any
    correction: Any
    last_correction: Any
    xi_change: Any
    rate_change: Any
    scale: Any
    sizes: Any
    history: Any


@jit
def new_iteration(unknowns, d, m, s):
    """A ``Newton`` with arrays for this number of unknowns."""
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
    """``correction`` <- -matrix^-1 R, with its changes of xi and xi'."""
    R, correction, first, rhs = newton.R, newton.correction, basis.first, newton.rhs
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            rhs[first[a] + i] = -R[a, i]
    substitute(newton.matrix, newton.pivots, rhs)
    correction[:, :] = 0.0
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            correction[a, i] = rhs[first[a] + i]
    place_curve(basis, h, correction, newton.xi_change, newton.rate_change)


@jit_noalloc
def add(x, share, correction):
    """x <- x + share correction, (d, m)."""
    for a in range(x.shape[0]):
        for i in range(x.shape[1]):
            x[a, i] += share * correction[a, i]


@jit_noalloc
def differentiate(law, method, scratch, start, curve, newton, max_derivatives, counts):
    """Form and factor the derivative at ``curve``, and the correction with it.

    Grows ``newton.scale`` and counts the forces and solves. Returns False if the derivative is
    singular.

    Parameters
    ----------
    max_derivatives
        number of derivatives that may be reusable. Each after the first takes its scales from the
        correction before it, since those of a motion from rest are not known earlier
    """
    d, s = curve.coordinates.shape
    scale, sizes, h = newton.scale, newton.sizes, start.h
    rate_scale = scales.largest(curve.rate)
    at_rest = rate_scale == 0.0
    for _ in range(max_derivatives):
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
        largest_rate = scales.largest(newton.rate_change)
        if not largest_rate > scales.BAD_SCALE_RATIO * rate_scale and not (
            at_rest and 0.0 < scales.BAD_SCALE_RATIO * largest_rate < rate_scale
        ):
            break
        scales.grow_scale(method.layout, newton.xi_change, newton.rate_change, h, scale)
        rate_scale = largest_rate
    scales.grow_scale(method.layout, newton.xi_change, newton.rate_change, h, scale)
    return True


@jit_noalloc
def verdict(method, h, curve, change, tolerance, history):
    """The code of the iteration after a pass with this relative change.

    A change that no longer shrinks counts as round-off up to ROUND_OFF_CHANGE times an
    amplification, which grows near the limit of the chart, but only where the velocities are
    resolved; elsewhere the root may be spurious.
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
    """The curve's x <- a solution, by Newton's method from x, with its forces and velocities.

    Returns SOLVED, DIVERGED (also after MAX_PASSES) or NOT_FINITE (also for a singular derivative).

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
    scale_at_solution, scale, history = np.empty(d), newton.scale, newton.history
    solve.reset_history(history)
    reusable = False  # whether the derivative may be used again
    fresh = False  # whether it was formed where the last correction began
    last, share = np.inf, 1.0
    place_curve(basis, h, x, coordinates, rate)
    position_scale(layout, g, scale)
    scales.grow_scale(layout, coordinates, rate, h, scale)
    for passes in range(MAX_PASSES):
        stage_slopes(law, layout, chart, scratch, start, curve)
        residual(method, scratch, start, curve, newton.R)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += s
        change = np.inf
        if reusable:
            correct(basis, h, newton)
            change = scales.relative_size(
                newton.xi_change, newton.rate_change, h, scale, scales.largest(rate)
            )
            nearly_solved = NEARLY_SOLVED * scales.amplification(layout, coordinates, rate, h)
            if allow_damping and not change <= last and last > nearly_solved:
                add(x, -share, newton.last_correction)
                reusable, share = fresh, 0.5 * share
                if fresh:
                    add(x, share, newton.last_correction)
                if share < SMALLEST_SHARE:
                    return solve.DIVERGED if change < np.inf else solve.NOT_FINITE
                place_curve(basis, h, x, coordinates, rate)
                continue
            reusable = change <= DERIVATIVE_CONTRACTION * last or change < nearly_solved
        fresh = not reusable
        if not reusable:
            max_derivatives = MAX_FIRST_DERIVATIVES if passes == 0 else 1
            if not differentiate(
                law, method, scratch, start, curve, newton, max_derivatives, counts
            ):
                return solve.NOT_FINITE
            change = scales.relative_size(
                newton.xi_change, newton.rate_change, h, scale, scales.largest(rate)
            )
            reusable = True
        copy_into(newton.last_correction, newton.correction)
        add(x, 1.0, newton.last_correction)
        last, share = change, 1.0
        place_curve(basis, h, x, coordinates, rate)
        if not scales.largest(coordinates) < np.inf:
            return solve.NOT_FINITE
        code = verdict(method, h, curve, change, tolerance, history)
        if code == solve.SOLVED:
            position_scale(layout, g, scale_at_solution)
            scales.grow_scale(layout, coordinates, rate, h, scale_at_solution)
            # Where a scale was a bad guess, go on with the smaller one.
            if not scales.shrink_scale(scale_at_solution, scale):
                stage_slopes(law, layout, chart, scratch, start, curve)
                counts[solve.FORCES] += s
                return solve.SOLVED
            solve.reset_history(history)
            last = np.inf
        elif code != solve.GOING:
            return code
    return solve.DIVERGED
