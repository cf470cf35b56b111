"""Newton's iteration for one step on a group; notation of galvi.kernels.group_stages."""

from __future__ import annotations

import numpy as np

from galvi.kernels import charts
from galvi.kernels.elimination import factor, substitute
from galvi.kernels.group_stages import derivative, place_curve, residual, stage_slopes
from galvi.kernels.jit import jit
from galvi.kernels.solve import (
    DIVERGED,
    FORCES,
    GOING,
    ITERATIONS,
    NOT_FINITE,
    SOLVED,
    SOLVES,
    forget,
    verdict,
)

PASSES = 60
RENEW = 0.2  # contraction above which the derivative is formed anew
PULLS = 4  # corrections of a first guess for the chart's tangent map


@jit
def coefficients(first, fit, h, rates, x):
    """x (d, m) <- those of the curve nearest to rates xi' (d, s) at the stages."""
    x[:, :] = 0.0
    for a in range(x.shape[0]):
        for i in range(first[a + 1] - first[a]):
            total = 0.0
            for j in range(rates.shape[1]):
                total += fit[i, j] * rates[a, j]
            x[a, i] = h * total


@jit
def guess_curve(layout, chart, basis, fit, h, velocities, x):
    """x <- coefficients of a curve with about these velocities (d, s) at the stages.

    xi' = T(xi)^-1 velocity, where xi is improved a few times; fit (m, s) takes rates to x / h.
    """
    d, s = velocities.shape
    place, rate = np.zeros((d, s)), np.empty((d, s))
    xi, eta, T, G = np.empty(d), np.zeros(d), np.empty((d, d)), np.empty((d, d))
    pivots = np.empty(d, np.int64)
    pace = velocities.copy()
    for _pull in range(PULLS):
        coefficients(basis[5], fit, h, pace, x)
        place_curve(basis, h, x, place, rate)
        for j in range(s):
            for a in range(d):
                xi[a] = place[a, j]
            charts.tangent(layout, chart, xi, eta, T, G)
            solved = np.empty(d)
            for a in range(d):
                solved[a] = velocities[a, j]
            if factor(T, pivots):
                substitute(T, pivots, solved)
            for a in range(d):
                pace[a, j] = solved[a]


@jit
def form(
    law, layout, chart, basis, scale, h, g, mu0, t, x, place, rate, forces, matrix, pivots, counts
):
    """The factored derivative at the stages; whether it is regular."""
    d, s = place.shape
    derivative(law, layout, chart, basis, scale, h, g, mu0, t, x, place, rate, forces, matrix)
    counts[FORCES] += 4 * d * s
    counts[SOLVES] += 1
    return factor(matrix, pivots)


@jit
def solve_group(law, layout, chart, basis, h, t, g, mu0, scale, tolerance, counts, x, forces,
                velocities):  # fmt: skip
    """x (d, m) <- the solution nearest to x; forces and velocities there. Returns a code.

    The derivative is kept as long as the iteration contracts well.
    """
    d, m = x.shape
    s, first = t.size, basis[5]
    unknowns = first[d]
    place, rate, before = np.empty((d, s)), np.empty((d, s)), np.empty((d, s))
    R, step = np.empty((d, m)), np.empty(unknowns)
    matrix, pivots = np.empty((unknowns, unknowns)), np.empty(unknowns, np.int64)
    history = np.empty(4)
    forget(history)
    fresh, last = False, np.inf
    place_curve(basis, h, x, place, rate)
    for _pass in range(PASSES):
        stage_slopes(law, layout, chart, g, t, place, rate, forces, velocities)
        residual(layout, chart, basis, h, mu0, forces, x, R)
        counts[ITERATIONS] += 1
        counts[FORCES] += s
        if not fresh:
            if not form(law, layout, chart, basis, scale, h, g, mu0, t, x, place, rate, forces,
                        matrix, pivots, counts):  # fmt: skip
                return NOT_FINITE
            fresh = True
        for a in range(d):
            for i in range(first[a + 1] - first[a]):
                step[first[a] + i] = -R[a, i]
        substitute(matrix, pivots, step)
        for a in range(d):
            for i in range(first[a + 1] - first[a]):
                x[a, i] += step[first[a] + i]
            for j in range(s):
                before[a, j] = place[a, j]
        place_curve(basis, h, x, place, rate)
        change = 0.0
        total = 0.0
        for a in range(d):
            for j in range(s):
                change = max(change, abs(place[a, j] - before[a, j]) / scale[a])
                total += abs(place[a, j])
        if not total < np.inf:
            return NOT_FINITE
        code = verdict(change, tolerance, history)
        if code == SOLVED:
            stage_slopes(law, layout, chart, g, t, place, rate, forces, velocities)
            counts[FORCES] += s
            return SOLVED
        if code != GOING:
            return DIVERGED if code != NOT_FINITE else code
        fresh = change <= RENEW * last or change < 1e-10
        last = change
    return DIVERGED
