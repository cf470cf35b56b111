"""Many steps on a group: predict, solve, complete, record; as galvi.kernels.nystrom.advance.

state         (4, n)   0: g (r,)
                       1: mu (d,), zeros (d,), and nu (d,), the momentum along the axes of space;
                       only mu without rotations
                       2: memory (r,) of galvi.kernels.lie.groups, zeros after this kernel
                       3: low parts of nu, or else of mu (d,), and of memory (r,)
stages        (d, s)   velocities at the last step's stages, from which the next is predicted
solver_state  (4,)     [LAST_STEP, GUESS or RATES; steps left to this kernel; done; -]
turned        (1,)     rotation angle of a step that left the chart
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import VECTOR, compiled_for, jit
from galvi.kernels.forces.lagrangian_derivatives import LAW_TUPLE, Law
from galvi.kernels.forces.passages import note_passages
from galvi.kernels.lie import product
from galvi.kernels.lie.dispatch import angle_of
from galvi.kernels.lie.product import is_flat
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.nystrom.step import copy_into, predict
from galvi.kernels.on_group.solve import coefficients, guess_curve, solve_group
from galvi.kernels.on_group.stages import BASIS, Basis, carried, end_place, place_curve
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, record, watched_row

STREAK = 1
LEFT_CHART = 4
RATES = 3  # content of stages, as in galvi.kernels.nystrom.advance: xi' of the next step


@jit
def arrive(layout, chart, basis, h, g, forces, x, g1, mu, nu, low):
    """g1, and mu, nu and low (d,) moved to the step's end; returns the largest |xi(1)| of a
    rotation."""
    d = x.shape[0]
    xi, kick = np.empty(d), np.empty(d)
    end_place(basis, x, xi)
    carried(basis, h, np.zeros(d), forces, kick)
    product.place(layout, chart, g, xi, g1)
    product.restore(layout, g1)
    product.carry(layout, chart, g, g1, xi, kick, mu, nu, low)
    return product.largest_rotation(layout, xi)


@jit
def advance_group(law, layout, chart, farthest, basis, plan, todo, progress, turned, kept):
    """Do ``todo`` more steps; returns a code. A step that fails leaves the state unchanged.

    farthest  largest |xi| of a rotation that the chart allows
    """
    law, basis, plan, kept = Law(*law), Basis(*basis), Plan(*plan), Kept(*kept)
    state, stages, solver_state, counts, passage = progress
    h, d, s = plan.step, stages.shape[0], stages.shape[1]
    m, r = basis.end.size, kept.q.shape[1]
    x, t, velocities = np.empty((d, m)), np.empty(s), np.empty((d, s))
    forces = np.empty((3, d, s))
    g, mu, g1, mu1, low = np.empty(r), np.empty(d), np.empty(r), np.empty(d), np.empty(d)
    nu = np.empty(d if state.shape[1] >= 3 * d else 0)
    place, rate = np.empty((d, s)), np.empty((d, s))
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for i in range(r):
            g[i] = state[0, i]
        for i in range(d):
            mu[i] = mu1[i] = state[1, i]
            low[i] = state[3, i]
        for i in range(nu.size):
            nu[i] = state[1, 2 * d + i]
        for j in range(s):
            t[j] = plan.t0 + ((plan.first + step) + basis.c[j]) * h
        if solver_state[HOLDS] == LAST_STEP:
            predict(basis, stages, velocities)
        else:
            copy_into(velocities, stages)
        if solver_state[HOLDS] == RATES:
            coefficients(basis, h, velocities, x)
        else:
            guess_curve(layout, chart, basis, h, velocities, x)
        allow_damping = is_flat(layout) or solver_state[HOLDS] == RATES
        code = solve_group(law, layout, chart, basis, h, t, g, mu, plan.tolerance, allow_damping,
                           counts, x, forces, velocities)  # fmt: skip
        if code != SOLVED:
            return code
        reached = arrive(layout, chart, basis, h, g, forces, x, g1, mu1, nu, low)
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
        copy_into(stages, velocities)
        state[1:, :] = 0.0
        for i in range(r):
            state[0, i] = g1[i]
        for i in range(d):
            state[1, i], state[3, i] = mu1[i], low[i]
        for i in range(nu.size):
            state[1, 2 * d + i] = nu[i]
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, g, g1, mu1)
        if kept.bases.shape[0] > 0:
            copy_into(kept.curves[step], x)
        row = watched_row(plan, kept, step)
        if row >= 0 and kept.seen.shape[1] > r + d:
            for i in range(d):
                for j in range(s):
                    kept.seen[row, r + d + i * s + j] = velocities[i, j]
        if passage.size > 0:  # point masses, on R^d
            place_curve(basis, h, x, place, rate)
            for i in range(d):
                for j in range(s):
                    place[i, j] += g[i]
            note_passages(passage, place, basis.c, g, g1, h, m, np.inf, plan.first + step + 1)
    return SOLVED


@cache
def compiled_advance_group():
    """``advance_group`` compiled or cached, one kernel for all systems."""
    whole, real = types.int64, types.float64
    signature = whole(
        LAW_TUPLE, types.int64[:, ::1], whole, real, BASIS, PLAN, whole, PROGRESS, VECTOR, KEPT
    )
    return compiled_for(advance_group, signature)
