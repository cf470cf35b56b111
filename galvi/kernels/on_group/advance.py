"""Many steps on a group: predict, solve, complete, record; as galvi.kernels.nystrom.advance.

state    (4, n)  g and mu in the first entries of their rows; see galvi.kernels.lanes.body for the
                 momentum in space, which is kept here too
stages   (d, s)  velocities at the last step's stages, the next prediction's source
memo     (4,)    [LAST_STEP, GUESS or RATES; steps left to this kernel; done; -]
turned   (1,)    the angle of a step that left the chart
saved_g (saved, r), saved_mu (saved, d), bases (steps, r), curves (steps, d, m)
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import MATRIX, TENSOR3, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.lie import product
from galvi.kernels.lie.chart_functions import angle_of
from galvi.kernels.lie.product import is_flat, is_one_rotation
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP, TABLEAU
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.nystrom.step import copy_into, predict
from galvi.kernels.on_group.solve import coefficients, guess_curve, solve_group
from galvi.kernels.on_group.stages import carried, end_momentum, end_place

STREAK = 1
LEFT_CHART = 4
RATES = 3  # what stages may hold, besides galvi.kernels.nystrom.advance: xi' of the step to come


@jit
def arrive(layout, chart, basis, h, g, mu0, forces, x, g1, mu1):
    """g1 and mu1 at the end of a step; returns the largest |xi(1)| of a rotation."""
    d = x.shape[0]
    xi, momentum, p1 = np.empty(d), np.empty(d), np.empty(d)
    end_place(basis, x, xi)
    carried(basis, h, mu0, forces, momentum)
    T, G = np.empty((d, d)), np.empty((d, d))
    end_momentum(layout, chart, T, G, xi, momentum, mu1, p1)
    product.place(layout, chart, g, xi, g1)
    product.restore(layout, g1)
    return product.largest_rotation(layout, xi)


@jit
def momentum_in_space(basis, h, g, forces, state, g1, mu1):
    """Of one rotating body: state[1, 6:9] += R h sum_j b_j n_j, and mu1 <- R1^T of it.

    So that what rounding does to mu1 is not handed on; as in galvi.kernels.lanes.body_update.
    """
    kick = np.empty(3)
    carried(basis, h, np.zeros(3), forces, kick)
    for i in range(3):
        for j in range(3):
            state[1, 6 + i] += g[3 * i + j] * kick[j]
    for i in range(3):
        mu1[i] = 0.0
        for j in range(3):
            mu1[i] += g1[3 * j + i] * state[1, 6 + j]


@jit
def advance_group(functions, kind, timed, side, constants, pushed, push_constants, layout, chart,
                  farthest, tableau, psi, slope, end, fit, unknowns, t0, h, tolerance, first, todo,
                  total, every, state, stages, memo, turned, counts, saved_g, saved_mu, bases,
                  curves):  # fmt: skip
    """Do ``todo`` more steps; returns a code. A step that fails leaves the state where it was.

    psi, slope, end  (s, m), (s, m), (m,)  basis and its derivative at the stages, basis at 1
    fit              (m, s)  takes rates at the stages to x / h
    unknowns         (d + 1,) first of each component, see galvi.kernels.on_group.stages
    farthest         largest |xi| of a rotation that the chart is trusted with
    """
    law = (functions, kind, timed, side, constants, pushed, push_constants)
    c, b = tableau[0], tableau[1]
    d, s = stages.shape
    m, r = end.size, saved_g.shape[1]
    basis = (psi, slope, end, b, c, unknowns)
    x, t, velocities = np.empty((d, m)), np.empty(s), np.empty((d, s))
    forces = np.empty((3, d, s))
    g, mu, g1, mu1 = np.empty(r), np.empty(d), np.empty(r), np.empty(d)
    last = saved_g.shape[0] - 1
    for step in range(memo[DONE], memo[DONE] + todo):
        for i in range(r):
            g[i] = state[0, i]
        for i in range(d):
            mu[i] = state[1, i]
        for j in range(s):
            t[j] = t0 + ((first + step) + c[j]) * h
        if memo[HOLDS] == LAST_STEP:
            predict(tableau, stages, velocities)
        else:
            copy_into(velocities, stages)
        if memo[HOLDS] == RATES:
            coefficients(unknowns, fit, h, velocities, x)
        else:
            guess_curve(layout, chart, basis, fit, h, velocities, x)
        bold = is_flat(layout) or memo[HOLDS] == RATES
        code = solve_group(law, layout, chart, basis, h, t, g, mu, tolerance, bold, counts, x,
                           forces, velocities)  # fmt: skip
        if code != SOLVED:
            return code
        reached = arrive(layout, chart, basis, h, g, mu, forces, x, g1, mu1)
        if not reached <= farthest:
            turned[0] = angle_of(chart, reached)
            return LEFT_CHART
        size = 0.0
        for i in range(r):
            size += abs(g1[i])
        for i in range(d):
            size += abs(mu1[i])
        if not size < np.inf:
            return NOT_FINITE
        if is_one_rotation(layout):
            momentum_in_space(basis, h, g, forces, state, g1, mu1)
        for i in range(r):
            state[0, i] = g1[i]
        for i in range(d):
            state[1, i] = mu1[i]
        copy_into(stages, velocities)
        state[2, :] = 0.0  # what the packed kernel knows of it is out of date
        state[3, :] = 0.0
        memo[HOLDS], memo[DONE] = LAST_STEP, step + 1
        if bases.shape[0] > 0:
            for i in range(r):
                bases[step, i] = g[i]
            copy_into(curves[step], x)
        if (step + 1) % every == 0:
            saved_g[(step + 1) // every, :] = g1
            saved_mu[(step + 1) // every, :] = mu1
        if step + 1 == total:
            saved_g[last, :] = g1
            saved_mu[last, :] = mu1
    return SOLVED


@cache
def compiled_advance_group():
    """``advance_group`` compiled for every system at once, or from the cache on disk."""
    whole, real, matrix = types.int64, types.float64, MATRIX
    fixed, counts = types.Array(real, 2, "C", readonly=True), types.int64[::1]
    signature = whole(
        counts, whole, types.boolean, whole, VECTOR, whole, VECTOR, types.int64[:, ::1], whole,
        real, TABLEAU, fixed, fixed,
        types.Array(real, 1, "C", readonly=True), fixed, counts, real, real, real, whole, whole,
        whole, whole, matrix, matrix, counts, VECTOR, counts, matrix, matrix, matrix,
        TENSOR3,
    )  # fmt: skip
    return compiled_for(advance_group, signature)
