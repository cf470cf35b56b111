"""Many steps of point masses under gravity: `galvi.kernels.advance` in vector instructions.

The same method, prediction, stopping rule and compensated updates; a step that fixed-point
iteration cannot solve is left to the general kernel. One compilation serves every number of
stages s, padded to P, a multiple of LANES.

d = bodies * dimension rows, one for each coordinate
masses   (bodies,)  G m
moves    (2 s, P)   h^2 A^T, then what rounding lost of it
ahead    (l s, P)   for r = 1 .. l: extrapolation that keeps r Legendre terms
series   (s, s)     Legendre coefficients from stages, transposed
growth   (l,)       Legendre polynomials at the next step's end
sums     (s, P)     columns h b, h^2 beta and what rounding lost of each
c        (2, P)     nodes, and what rounding lost of them
work     (7, d, P)  stages, last accelerations, h c v, corrections too small for it, guess, changes,
                    new accelerations
memo     (3 + bodies,)  as in the general kernel, then Legendre terms kept for each body
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels import laws
from galvi.kernels.advance import DONE, HOLDS, LAST_STEP, STREAK, TABLEAU, keep
from galvi.kernels.jit import compiled_for, jit
from galvi.kernels.lanes import LANES, attract, combine, drift, move
from galvi.kernels.solve import (
    DIVERGED,
    FIXED_POINT_PASSES,
    FORCES,
    GOING,
    ITERATIONS,
    NOT_FINITE,
    SOLVED,
    forget,
    verdict,
)
from galvi.kernels.step import (
    all_finite,
    copy_into,
    terms_to_extrapolate,
    two_product,
    two_sum,
)

RECONSIDER = 16  # steps between choices of how many terms to extrapolate


@jit
def pull_all(axes, masses, Q, a):
    """a <- gravitational accelerations at all stages."""
    bodies, padded = masses.size, Q.shape[1]
    for row in range(a.shape[0]):
        for k in range(padded):
            a[row, k] = 0.0
    for chunk in range(padded // LANES):
        for i in range(bodies - 1, 0, -1):  # light pairs first, the sums grow
            attract(axes, Q, a, masses, i - 1, i, bodies, padded, chunk)


@jit
def move_all(axes, moves, a, base, low, q, Q, worst, sizes):
    """Q <- q + (base + (low + h^2 A a)); returns the largest change relative to the sizes."""
    bodies, stages, padded = sizes.size, moves.shape[0] // 2, Q.shape[1]
    for chunk in range(padded // LANES):
        for k in range(LANES):
            worst[0, chunk * LANES + k] = 0.0
        for body in range(bodies):
            move(axes, moves, a, base, low, q, Q, worst, sizes[body], body, stages, padded, chunk)
    change, finite = 0.0, 0.0
    for k in range(padded):
        change = max(change, worst[0, k])
        finite += worst[0, k]
    return change if finite < np.inf else np.nan


@jit
def choose_terms(series, growth, dimension, a, terms):
    """How many Legendre terms of each body's last accelerations to extrapolate."""
    s = series.shape[0]
    for body in range(terms.size):
        sizes = np.zeros(s)
        for x in range(dimension):
            for l in range(s):
                coefficient = 0.0
                for j in range(s):
                    coefficient += series[j, l] * a[body * dimension + x, j]
                sizes[l] = max(sizes[l], abs(coefficient))
        terms[body] = terms_to_extrapolate(sizes, growth)


@jit
def finish(axes, sums, h, a, state, out):
    """The end of the step, as galvi.kernels.step.complete_step; ``out`` is scratch, (d, P)."""
    d, stages = a.shape[0], sums.shape[0]
    dimension = len(axes)
    for body in range(d // dimension):
        combine(axes, sums, 0, a, out, body, stages, a.shape[1], 0)
    for i in range(d):
        q, q_low, v, v_low = state[0, i], state[1, i], state[2, i], state[3, i]
        far, far_low = two_product(h, v)
        moved, moved_low = two_sum(q, far)
        moved, bend_low = two_sum(moved, out[i, 1])
        rest = moved_low + (bend_low + (q_low + (far_low + (h * v_low + out[i, 3]))))
        state[0, i], state[1, i] = two_sum(moved, rest)
        kicked, kick_low = two_sum(v, out[i, 0])
        state[2, i], state[3, i] = two_sum(kicked, kick_low + (v_low + out[i, 2]))


@jit
def begin(dimension, c, h, state, base, low, sizes):
    """base <- h c v; low += what it and q lost; sizes <- 1 / distances from the origin."""
    padded = c.shape[1]
    for body in range(sizes.size):
        size = 0.0
        for x in range(dimension):
            i = body * dimension + x
            far, far_low = two_product(h, state[2, i])
            far_low += h * state[3, i]
            for chunk in range(padded // LANES):
                drift(c, base, low, i, far, far_low, state[1, i], padded, chunk)
            size = max(size, abs(state[0, i]), abs(state[0, i] + far))
        sizes[body] = size
    largest = sizes.max()
    for body in range(sizes.size):
        size = sizes[body] if sizes[body] > 0.0 else largest
        sizes[body] = 1.0 / size if size > 0.0 else 1.0


@jit
def iterate(axes, masses, moves, q, base, low, sizes, tolerance, counts, Q, a, worst, history):
    """Fixed-point iteration from stages Q, until settled; a holds the last accelerations."""
    forget(history)
    for _passes in range(FIXED_POINT_PASSES):
        pull_all(axes, masses, Q, a)
        change = move_all(axes, moves, a, base, low, q, Q, worst, sizes)
        counts[ITERATIONS] += 1
        counts[FORCES] += moves.shape[0] // 2
        code = verdict(change, tolerance, history)
        if code != GOING:
            return code
    return DIVERGED


@jit
def advance(axes, masses, tableau, moves, ahead, series, growth, sums, c, h, tolerance, first, todo,
            total, every, state, stages, work, memo, counts, saved_q, saved_v, bases,
            curves):  # fmt: skip
    """Do ``todo`` more steps of a run; returns a code as the general kernel does."""
    bodies, s, padded = masses.size, moves.shape[0] // 2, moves.shape[1]
    dimension, d = len(axes), state.shape[1]
    Q, a, base, low, guess, worst = work[0], work[1], work[2], work[3], work[4], work[5]
    new, terms = work[6], memo[3:]
    sizes, q, before = np.empty(bodies), np.empty(d), np.empty(state.shape)
    history = np.empty(4)
    copy_rows(a, stages)
    for step in range(memo[DONE], memo[DONE] + todo):
        if memo[STREAK] > 0:
            copy_rows(stages, a)
            return DIVERGED
        copy_into(before, state)
        for i in range(d):
            q[i] = state[0, i]
        source = a
        if memo[HOLDS] == LAST_STEP:
            if (first + step) % RECONSIDER == 0 or terms[0] == 0:
                choose_terms(series, growth, dimension, a, terms)
            for body in range(bodies):
                for chunk in range(padded // LANES):
                    start = (terms[body] - 1) * s
                    combine(axes, ahead, start, a, guess, body, s, padded, chunk)
            source = guess
        for body in range(bodies):
            for chunk in range(padded // LANES):
                combine(axes, moves, s, source, low, body, s, padded, chunk)
        begin(dimension, c, h, state, base, low, sizes)
        move_all(axes, moves, source, base, low, q, Q, worst, sizes)
        code = iterate(
            axes, masses, moves, q, base, low, sizes, tolerance, counts, Q, new, worst, history
        )
        if code == SOLVED:
            finish(axes, sums, h, new, state, guess)
            if not all_finite(state):
                code = NOT_FINITE
        if code != SOLVED:
            copy_into(state, before)
            copy_rows(stages, a)
            return code
        a, new = new, a
        if bases.shape[0] > 0:
            copy_rows(stages, a)
        memo[HOLDS], memo[DONE] = LAST_STEP, step + 1
        keep(tableau, h, every, step, total, before, state, stages, saved_q, saved_v, bases, curves)
    copy_rows(stages, a)
    return SOLVED


@jit
def copy_rows(target, source):
    """The first columns of target <- source, as many as both have."""
    for i in range(target.shape[0]):
        for k in range(min(target.shape[1], source.shape[1])):
            target[i, k] = source[i, k]


@cache
def compiled_advance(dimension):
    """``advance`` for bodies in the plane or in space, from the cache on disk if it is there."""
    fixed = types.Array(types.float64, 1, "C", readonly=True)
    fixed_matrix = types.Array(types.float64, 2, "C", readonly=True)
    whole, real, matrix = types.int64, types.float64, laws.MATRIX
    signature = whole(
        types.UniTuple(whole, dimension), fixed, TABLEAU, fixed_matrix, fixed_matrix, fixed_matrix,
        fixed, fixed_matrix, fixed_matrix, real, real, whole, whole, whole, whole, matrix, matrix,
        laws.BLOCKS, types.int64[::1], types.int64[::1], matrix, matrix, matrix, laws.BLOCKS,
    )  # fmt: skip
    return compiled_for(advance, signature)
