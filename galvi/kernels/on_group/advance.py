"""Many steps on a group: predict, solve, complete, record; as galvi.kernels.nystrom.advance.

state         (4, n)   0: g (r,)
                       1: mu (d,), zeros (d,), and nu (d,), the momentum along the axes of space;
                       only mu without rotations
                       2: memory (r,) of galvi.kernels.lie.groups, zeros after this kernel
                       3: low parts of nu, or else of mu (d,), and of memory (r,)
stages        (d, s)   velocities at the last step's stages, from which the next is predicted
solver_state  (4,)     content of stages (LAST_STEP, GUESS or RATES), number of steps that remain
for
                       this kernel, number of steps done, not used
turned        (1,)     set to the rotation angle of a step that leaves the chart
"""

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import VECTOR, compiled_for, jit, jit_noalloc
from galvi.kernels.forces.lagrangian_derivatives import LAW_TUPLE, Law
from galvi.kernels.forces.passages import note_passages
from galvi.kernels.lie import product
from galvi.kernels.lie.dispatch import angle_of
from galvi.kernels.lie.product import is_flat
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.nystrom.step import copy_into, predict
from galvi.kernels.on_group.solve import coefficients, guess_curve, solve_group
from galvi.kernels.on_group.stages import (
    BASIS,
    Basis,
    Curve,
    Discretisation,
    Start,
    end_coordinates,
    end_momentum_in_frame,
)
from galvi.kernels.run_record import PLAN, PROGRESS, RECORDING, Plan, Recording, record, watched_row

LEFT_CHART = 4
RATES = 3  # content of stages, as in galvi.kernels.nystrom.advance: xi' of the next step


@jit
def end_step(method, start, curve, g1, mu, nu, low):
    """Set g1, mu, nu and low at the step's end; returns the largest |xi(1)| of a rotation."""
    layout, chart, g, d = method.layout, method.chart, start.g, mu.size
    xi, kick = np.empty(d), np.empty(d)
    end_coordinates(method.basis, curve.x, xi)
    end_momentum_in_frame(method.basis, start.h, np.zeros(d), curve.forces, kick)
    product.place(layout, chart, g, xi, g1)
    product.restore(layout, g1)
    product.carry(layout, chart, g, g1, xi, kick, mu, nu, low)
    return product.largest_rotation(layout, xi)


@jit_noalloc
def copy_vector(target, source, first):
    """target (n,) <- source[first : first + n]; slices would take longer."""
    for i in range(target.size):
        target[i] = source[first + i]


@jit_noalloc
def set_state(state, g, mu, nu, low):
    """Set the state (4, n) at the end of a step."""
    d = mu.size
    state[1:, :] = 0.0
    for i in range(g.size):
        state[0, i] = g[i]
    for i in range(d):
        state[1, i], state[3, i] = mu[i], low[i]
    for i in range(nu.size):
        state[1, 2 * d + i] = nu[i]


@jit_noalloc
def sum_of_sizes(x):
    """The sum of |x_i|."""
    total = 0.0
    for i in range(x.size):
        total += abs(x[i])
    return total


@jit
def guess(method, start, stages, holds, curve):
    """Set the curve's x and velocities for the start of the iteration, from the stages."""
    if holds == LAST_STEP:
        predict(method.basis, stages, curve.velocities)
    else:
        copy_into(curve.velocities, stages)
    if holds == RATES:
        coefficients(method.basis, start.h, curve.velocities, curve.x)
    else:
        guess_curve(method.layout, method.chart, method.basis, start.h, curve.velocities, curve.x)


@jit_noalloc
def record_step(plan, recording, step, start, nodes, curve, g1, mu1, passage):
    """Record the step that ends at (g1, mu1)."""
    (d, s), r, m = curve.coordinates.shape, g1.size, curve.x.shape[1]
    record(plan, recording, step, start.g, g1, mu1)
    if recording.bases.shape[0] > 0:
        copy_into(recording.curves[step], curve.x)
    row = watched_row(plan, recording, step)
    if row >= 0 and recording.watched.shape[1] > r + d:
        for i in range(d):
            for j in range(s):
                recording.watched[row, r + d + i * s + j] = curve.velocities[i, j]
    if passage.size > 0:  # point masses, on R^d
        for i in range(d):
            for j in range(s):
                curve.coordinates[i, j] += start.g[i]
        number = plan.first + step + 1
        note_passages(passage, curve.coordinates, nodes, start.g, g1, start.h, m, np.inf, number)


@jit
def advance_group(
    law, layout, chart, largest_rotation, basis, plan, todo, progress, turned, recording
):
    """Do ``todo`` more steps; returns SOLVED, LEFT_CHART or another code.

    A step that fails leaves the state unchanged.

    Parameters
    ----------
    farthest
        largest |xi| of a rotation that the chart allows
    """
    law, method = Law(*law), Discretisation(layout, chart, Basis(*basis))
    plan, recording, basis = Plan(*plan), Recording(*recording), method.basis
    state, stages, solver_state, counts, passage = progress
    (d, s), m, r = stages.shape, basis.end.size, recording.q.shape[1]
    curve = Curve(
        np.empty((d, m)), np.empty((d, s)), np.empty((d, s)), np.empty((3, d, s)), np.empty((d, s))
    )
    start = Start(plan.step, np.empty(s), np.empty(r), np.empty(d))
    g1, mu1, low = np.empty(r), np.empty(d), np.empty(d)
    nu = np.empty(d if state.shape[1] >= 3 * d else 0)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        copy_vector(start.g, state[0], 0)
        copy_vector(start.mu0, state[1], 0)
        copy_vector(mu1, state[1], 0)
        copy_vector(low, state[3], 0)
        copy_vector(nu, state[1], 2 * d)
        for j in range(s):
            start.t[j] = plan.t0 + ((plan.first + step) + basis.c[j]) * plan.step
        guess(method, start, stages, solver_state[HOLDS], curve)
        allow_damping = is_flat(layout) or solver_state[HOLDS] == RATES
        code = solve_group(law, method, start, curve, plan.tolerance, allow_damping, counts)
        if code != SOLVED:
            return code
        rotation = end_step(method, start, curve, g1, mu1, nu, low)
        if not rotation <= largest_rotation:
            turned[0] = angle_of(chart, rotation)
            return LEFT_CHART
        if not sum_of_sizes(g1) + sum_of_sizes(mu1) < np.inf:
            return NOT_FINITE
        copy_into(stages, curve.velocities)
        set_state(state, g1, mu1, nu, low)
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record_step(plan, recording, step, start, basis.c, curve, g1, mu1, passage)
    return SOLVED


@cache
def compiled_advance_group():
    """The compiled ``advance_group``, one kernel for all systems."""
    integer, real = types.int64, types.float64
    signature = integer(
        LAW_TUPLE,
        types.int64[:, ::1],
        integer,
        real,
        BASIS,
        PLAN,
        integer,
        PROGRESS,
        VECTOR,
        RECORDING,
    )
    return compiled_for(advance_group, signature)
