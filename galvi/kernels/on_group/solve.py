"""Newton's iteration for one step on a group; notation of galvi.kernels.on_group.stages."""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit, jit_noalloc
from galvi.kernels.lie import product
from galvi.kernels.lie.product import is_flat, position_scale
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.step import copy_into
from galvi.kernels.on_group import scale as scales
from galvi.kernels.on_group.derivative import derivative, factor, substitute
from galvi.kernels.on_group.stages import new_scratch, place_curve, residual, stage_slopes

PASSES = 60
RENEW = 0.2  # contraction factor above which the derivative is recomputed
NEAR = 1e-10  # relative change below which neither that nor damping is done
MEASURED = 4  # most derivatives at the start of a step, each with scales from the one before
SHORTEST = 2.0**-24  # smallest share of a correction that is tried
PULLS = 4  # corrections of an initial guess by the chart's tangent map


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
    place, rate = np.zeros((d, s)), np.empty((d, s))
    xi, velocity, solved = np.empty(d), np.empty(d), np.empty(d)
    rates = velocities.copy()
    for _pull in range(PULLS):
        coefficients(basis, h, rates, x)
        place_curve(basis, h, x, place, rate)
        for j in range(s):
            for a in range(d):
                xi[a], velocity[a] = place[a, j], velocities[a, j]
            product.rate(layout, chart, xi, velocity, solved)
            for a in range(d):
                rates[a, j] = solved[a]


@jit
def correct(matrix, pivots, first, R, step):
    """step (d, m) <- -matrix^-1 R."""
    flat = np.empty(first[R.shape[0]])
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            flat[first[a] + i] = -R[a, i]
    substitute(matrix, pivots, flat)
    step[:, :] = 0.0
    for a in range(R.shape[0]):
        for i in range(first[a + 1] - first[a]):
            step[a, i] = flat[first[a] + i]


@jit_noalloc
def add(x, factor_, step):
    """x <- x + factor_ step, (d, m)."""
    for a in range(x.shape[0]):
        for i in range(x.shape[1]):
            x[a, i] += factor_ * step[a, i]


@jit
def solve_group(law, layout, chart, basis, h, t, g, mu0, tolerance, allow_damping, counts, x,
                forces, velocities):  # fmt: skip
    """x (d, m) <- the solution nearest to x; forces and velocities there. Returns a code.

    The derivative is reused while the iteration contracts well. If a correction is larger than the
    one before, the latter is undone and repeated with a new derivative or halved (natural
    monotonicity test: Deuflhard, Newton Methods for Nonlinear Problems, 3.3). Far from a good
    guess, damping may find another root, whose rotation exceeds the chart, so it is used only if
    ``allow_damping``. The scale of a motion from rest is known only after the first correction; the
    differences are then repeated. What changes that no longer shrink may be, to be round-off, grows
    with the coordinates of rotations near the chart's limit.
    """
    d, m = x.shape
    s, first = t.size, basis.first
    place, rate = np.empty((d, s)), np.empty((d, s))
    to_place, to_rate = np.empty((d, s)), np.empty((d, s))
    R, ahead, step = np.empty((d, m)), np.empty((d, m)), np.empty((d, m))
    matrix, pivots = np.empty((first[d], first[d])), np.empty(first[d], np.int64)
    scratch, history, scale = new_scratch(d, g.size, m), np.empty(4), np.empty(d)
    now, sizes = np.empty(d), np.empty(d)
    solve.reset_history(history)
    formed = here = False  # whether a derivative exists, and whether at step's start
    last, share = np.inf, 1.0
    place_curve(basis, h, x, place, rate)
    position_scale(layout, g, scale)
    scales.grow_scale(layout, place, rate, h, scale)
    for passes in range(PASSES):
        stage_slopes(law, layout, chart, scratch, g, t, place, rate, forces, velocities)
        residual(layout, chart, basis, scratch, h, mu0, forces, x, R)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += s
        if formed:
            correct(matrix, pivots, first, R, ahead)
            place_curve(basis, h, ahead, to_place, to_rate)
            change = scales.relative(to_place, to_rate, h, scale, scales.largest(rate))
            near = NEAR * scales.amplification(layout, place, rate, h)
            if allow_damping and not change <= last and last > near:
                add(x, -share, step)
                formed, share = here, 0.5 * share
                if here:
                    add(x, share, step)
                if share < SHORTEST:
                    return solve.DIVERGED if change < np.inf else solve.NOT_FINITE
                place_curve(basis, h, x, place, rate)
                continue
            formed = change <= RENEW * last or change < near
        here = not formed
        if not formed:
            rate_scale = scales.largest(rate)
            at_rest = rate_scale == 0.0
            for _measured in range(MEASURED if passes == 0 else 1):
                size = 0.0
                for a in range(d):
                    sizes[a] = scale[a] if scale[a] > 0.0 else 1.0
                    size = max(size, sizes[a])
                rate_scale = rate_scale if rate_scale > 0.0 else size / abs(h)
                rate_scale = max(rate_scale, scales.SMALLEST)
                derivative(law, layout, chart, basis, scratch, sizes, rate_scale, h, g, mu0, t, x,
                           place, rate, forces, matrix)  # fmt: skip
                counts[solve.FORCES] += 2 * d * s
                counts[solve.SOLVES] += 1
                if not factor(matrix, pivots):
                    return solve.NOT_FINITE
                correct(matrix, pivots, first, R, ahead)
                place_curve(basis, h, ahead, to_place, to_rate)
                found = scales.largest(to_rate)
                if not found > scales.FAR * rate_scale and not (
                    at_rest and 0.0 < scales.FAR * found < rate_scale
                ):
                    break
                scales.grow_scale(layout, to_place, to_rate, h, scale)
                rate_scale = found
            scales.grow_scale(layout, to_place, to_rate, h, scale)
            change = scales.relative(to_place, to_rate, h, scale, scales.largest(rate))
            formed = True
        copy_into(step, ahead)
        add(x, 1.0, step)
        last, share = change, 1.0
        place_curve(basis, h, x, place, rate)
        if not scales.largest(place) < np.inf:
            return solve.NOT_FINITE
        code = solve.verdict(change, tolerance, history)
        if code != solve.NOT_FINITE and history[3] >= solve.IDLE:
            round_off = solve.FLOOR * scales.amplification(layout, place, rate, h)
            if history[2] <= round_off and scales.is_resolved(basis.analysis, velocities):
                code = solve.SOLVED
        if code == solve.SOLVED:
            position_scale(layout, g, now)
            scales.grow_scale(layout, place, rate, h, now)
            if not scales.shrink_scale(now, scale):
                stage_slopes(law, layout, chart, scratch, g, t, place, rate, forces, velocities)
                counts[solve.FORCES] += s
                return solve.SOLVED
            solve.reset_history(history)
            last = np.inf
        elif code != solve.GOING:
            return solve.DIVERGED if code != solve.NOT_FINITE else code
    return solve.DIVERGED
