"""Many steps of a Lagrangian on a Lie group in vector instructions, as galvi.kernels.on_group.

With A and B those of galvi.kernels.lanes.law, rates eta and forces f in the chart at the step's
start, and n and mu as in galvi.kernels.on_group.stages, the stage equations are

    xi_j = h sum_k A_jk eta_k,                       xi(1) = h sum_k b_k eta_k,
    pi_j = p0 + h sum_k B_jk f_k + sum_l m_l Y_lj,   p1 = p0 + h sum_k b_k f_k = T(xi(1))^T mu1,
    mu1 = Ad*_{Phi(xi(1))} (mu0 + h sum_k b_k n_k),  sum_j b_j Y_lj eta_j = 0

p0 would be mu0 if the base point of the chart were fixed; it differs by the error of a step. With
more points than coefficients, rates of curves are orthogonal to the functions Y_l, and a multiplier
m_l is the momenta's part along Y_l. A pass of the iteration takes forces from the last xi and eta,
pi from the forces, eta from one Newton step for T^T dL/dv = pi with the last mass, projected to the
rates of curves, and xi from eta. A step for which that does not converge, or whose rotation exceeds
REACHES, is left to the general kernel.

law           (1,)      address of the law's galvi.kernels.lanes.group_pass
layout, chart           as in galvi.kernels.lie.product
constants     (c,)      constants of the law
state, solver_state     as in galvi.kernels.on_group.advance; solver_state[3] is the number of
                        Legendre terms extrapolated
tables, complement, numbers, work   as in galvi.kernels.lanes.group_pass
kicks         (s, P)    columns h b and its low part, then zeros
ahead         (l s, P)  for r = 1 .. l: extrapolation of velocities that keeps r Legendre terms
series        (s, P)    Legendre coefficients from stages, transposed
growth        (l,)      Legendre polynomials at the next step's end
fit           (m, s)    h times the coefficients of a curve from its rates at the stages
c             (P,)      nodes
spare         (13, at least P and the width of state)   scratch, and the state before the step
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import MATRIX, VECTOR
from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import compiled_for, jit_inline, jit_noalloc
from galvi.kernels.lanes.gravity import combine
from galvi.kernels.lanes.group_pass import (
    BEFORE,
    ETA,
    GUESS,
    LOW_PI,
    LOW_XI,
    PASS,
    PREPARE,
    REST,
    TIMES,
    VELOCITY,
    XI,
    F,
    N,
)
from galvi.kernels.lanes.law import AXES, TABLES, TERMS, curve_of, gather, terms_of, watch_stages
from galvi.kernels.lanes.nbody import RECONSIDER, copy_rows
from galvi.kernels.lie import product
from galvi.kernels.lie.chart_functions import REACHES
from galvi.kernels.lie.product import DIMENSION, ROTATIONS
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import (
    DIVERGED,
    FIXED_POINT_PASSES,
    FORCES,
    GOING,
    ITERATIONS,
    NOT_FINITE,
    SOLVED,
    reset_history,
    verdict,
)
from galvi.kernels.nystrom.step import copy_into
from galvi.kernels.on_group.scale import grow_scale
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, record

SAMPLE = 3  # one in so many stages is looked at for the sizes
PULLS = 2  # corrections of an initial guess by the chart's tangent map
NEAR = 1e-4  # relative change of the stages below which the error of p0 is evaluated
SURE = 3.0  # least ratio of the error of p0 to the last change for p0 to be corrected
LEAST = 3e-16  # largest relative error of p0 that is accepted
PATIENCE = 4.0  # growth of that limit from one attempt at convergence to the next


@jit_inline
def rows(block, d):
    """The rows of a block of work."""
    return slice(block * d, (block + 1) * d)


@jit_noalloc
def measure(layout, g, h, p0, work, numbers):
    """1 over the sizes of xi and pi in numbers, 0 where all are 0.

    Rotations have size 1. All translations of a factor share a size, that of its positions and
    displacements, and so do the momenta of its translations and of its rotations. An angular
    momentum is at least as large as what the displacements make of a momentum.
    """
    d = p0.size
    sizes, forces = numbers[d : 2 * d], work[rows(F, d)]
    xi, eta = work[rows(XI, d)], work[rows(ETA, d)]
    product.position_scale(layout, g, sizes)
    grow_scale(layout, xi, eta, h, sizes)
    start = 0
    for factor in range(layout.shape[0]):
        turns, end = start + layout[factor, ROTATIONS], start + layout[factor, DIMENSION]
        moving, moment, way = 0.0, 0.0, 0.0
        for i in range(start, end):
            size = abs(p0[i])
            for k in range(0, forces.shape[1], SAMPLE):
                size = max(size, abs(h * forces[i, k]))
                if i >= turns:
                    way = max(way, abs(h * eta[i, k]))
            if i < turns:
                moment = max(moment, size)
            else:
                moving = max(moving, size)
        moment = max(moment, moving * way)
        for i in range(start, end):
            size = moment if i < turns else moving
            numbers[2 * d + i] = 1.0 / size if size > 0.0 else 0.0
            numbers[d + i] = 1.0 / sizes[i] if sizes[i] > 0.0 else 0.0
        start = end


@jit_inline
def end_defect(layout, chart, kicks, stages, work, mu0, numbers, xi, kick, missing, room):
    """xi(1), the impulse h sum_k b_k n_k, and the error ``missing`` of p0; returns its size.

    In the frame of the step's start, p0 gives the final momentum Ad*^-1 T^-T (p0 + h sum_k b_k
    f_k), which should be mu0 + h sum_k b_k n_k. All vectors are (d,), room is (3, at least d).
    """
    d = mu0.size
    momentum, body, change, sums = room[0, :d], room[1, :d], room[2, :d], work[rows(REST, d)]
    for block in (ETA, F, N):
        values = work[rows(block, d)]
        for i in range(d):
            combine(AXES, kicks, 0, values, sums, i, stages, work.shape[1], 0)
            total = sums[i, 1] + sums[i, 0]
            if block == ETA:
                xi[i] = total
            elif block == F:
                momentum[i] = numbers[i] + total
            else:
                kick[i] = total
    product.covector(layout, chart, xi, momentum, body)
    product.coadjoint_change(layout, chart, xi, body, change)
    size = 0.0
    for i in range(d):
        missing[i] = (mu0[i] - body[i]) + (kick[i] - change[i])
        size = max(size, numbers[2 * d + i] * abs(missing[i]))
    return size


@jit_inline
def relax(law, layout, chart, constants, tables, complement, kicks, h, g, mu0, work, numbers,
          tolerance, counts, history, xi, kick, missing, room):  # fmt: skip
    """Passes from the xi and eta in work until convergence; returns a code.

    The error of p0, in numbers, is known to about the last change of the stages, and each
    correction costs some passes: it is made when it exceeds SURE times that change, and at the end.
    """
    d, stages = mu0.size, kicks.shape[0]
    p0, V, forces = numbers[:d], work[rows(ETA, d)], work[rows(F, d)]
    near, least, size = NEAR, LEAST, 0.0
    reset_history(history)
    for i in range(2 * d):
        numbers[d + i] = 0.0
    for passes in range(FIXED_POINT_PASSES):
        call_void(law[0], work, tables, complement, constants, numbers)
        counts[ITERATIONS] += 1
        counts[FORCES] += stages
        if passes == 0:  # the sizes of a motion from rest are known after it
            measure(layout, g, h, p0, work, numbers)
            gather(tables, stages, stages, V, work[rows(LOW_XI, d)])
            gather(tables, 3 * stages, stages, forces, work[rows(LOW_PI, d)])
            continue
        last, known = numbers[3 * d], False
        code = verdict(last, tolerance, history)
        if last <= near or code == SOLVED:
            size = end_defect(
                layout, chart, kicks, stages, work, mu0, numbers, xi, kick, missing, room
            )
            near, known = size / SURE, True
        if known and size > least and (code == SOLVED or near > last):
            for i in range(d):
                p0[i] += missing[i]
            near = last / SURE
            if code == SOLVED:
                near, least, code = 0.0, PATIENCE * least, GOING
            reset_history(history)
        if code != GOING:
            return code
    return DIVERGED


@jit_inline
def start(law, constants, tables, complement, s, work, numbers, d):
    """xi and eta from guessed velocities, by a few iterations of eta = T^-1 velocity."""
    xi = work[rows(XI, d)]
    gather(tables, 0, s, work[rows(VELOCITY, d)], xi)
    numbers[3 * d + 1] = GUESS
    for _pull in range(PULLS):
        call_void(law[0], work, tables, complement, constants, numbers)
    numbers[3 * d + 1] = PASS


@jit_noalloc
def within_reach(layout, chart, xi, end):
    """Whether the rotations of all stages (d, P) and of the end (d,) are within REACHES."""
    reach = REACHES[chart]
    start, farthest = 0, product.largest_rotation(layout, end)
    if not farthest <= reach:
        return False
    for factor in range(layout.shape[0]):
        for k in range(xi.shape[1]):
            square = 0.0
            for i in range(start, start + layout[factor, ROTATIONS]):
                square += xi[i, k] * xi[i, k]
            if not square <= reach * reach:
                return False
        start += layout[factor, DIMENSION]
    return True


@jit_noalloc
def add_late(h, factors, missing, xi):
    """xi(1) <- xi(1) + h M^-1 missing, the effect of the remaining error of p0 to first order.

    factors  (d (d + 1) / 2, P)  of the mass at the stages
    """
    d = xi.size
    for i in range(d):
        for j in range(i):
            missing[i] -= factors[i * (i + 1) // 2 + j, 0] * missing[j]
    for i in range(d):
        missing[i] *= factors[i * (i + 1) // 2 + i, 0]
    for i in range(d - 1, -1, -1):
        for j in range(i):
            missing[j] -= factors[i * (i + 1) // 2 + j, 0] * missing[i]
    for i in range(d):
        xi[i] += h * missing[i]


@jit_noalloc
def finish(layout, chart, xi, kick, p0, before, state):
    """The state at the step's end from that before; returns whether it is finite."""
    d, total = xi.size, 0.0
    r = state.shape[1]
    entries = 0
    for factor in range(layout.shape[0]):
        entries += layout[factor, 2]
    g, mu = state[0, :entries], state[1, :d]
    product.advance(layout, chart, xi, g, state[2, :entries], state[3, d : d + entries])
    product.carry(layout, chart, before[0], g, xi, kick, mu, state[1, 2 * d : 3 * d], state[3, :d])
    for i in range(d):
        state[1, d + i] = p0[i] - before[1, i]
    for i in range(r):
        total += abs(state[0, i]) + abs(state[1, i])
    return total < np.inf


@jit_inline
def advance_group_law(law, layout, chart, constants, given, plan, todo, progress, work, numbers,
                      spare, kept):  # fmt: skip
    """Do ``todo`` more steps; returns a code. A step that fails is not done."""
    plan, kept = Plan(*plan), Kept(*kept)
    kicks, ahead, series, tables, complement, growth, fit, c = given
    state, stages, solver_state, counts, _passage = progress
    d, r, s, h = stages.shape[0], kept.q.shape[1], kicks.shape[0], plan.step
    velocity, before, eta = work[rows(VELOCITY, d)], work[rows(BEFORE, d)], work[rows(ETA, d)]
    times, factors = work[TIMES * d], work[TIMES * d + 1 :]
    history, sizes, room = spare[0], spare[1], spare[2:5, :d]
    xi, kick, missing, mu0 = spare[5, :d], spare[6, :d], spare[7, :d], spare[8, :d]
    saved = spare[9:13, : state.shape[1]]
    numbers[3 * d + 1] = PREPARE
    call_void(law[0], work, tables, complement, constants, numbers)
    copy_rows(velocity, stages)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for k in range(times.size):
            times[k] = plan.t0 + ((plan.first + step) + c[k]) * h
        for i in range(d):
            mu0[i] = state[1, i]
            numbers[i] = mu0[i] + state[1, d + i]
            for k in range(velocity.shape[1]):
                before[i, k] = velocity[i, k] = velocity[i, min(k, s - 1)]
        for i in range(r):
            numbers[3 * d + 2 + i] = state[0, i]
        if solver_state[HOLDS] == LAST_STEP:
            if (plan.first + step) % RECONSIDER == 0 or solver_state[TERMS] == 0:
                solver_state[TERMS] = terms_of(series, growth, before, work[rows(REST, d)], sizes)
            gather(ahead, (solver_state[TERMS] - 1) * s, s, before, velocity)
        work[LOW_XI * d : (LOW_PI + 1) * d] = 0.0
        copy_into(saved, state)
        start(law, constants, tables, complement, s, work, numbers, d)
        code = relax(
            law, layout, chart, constants, tables, complement, kicks, h, saved[0, :r], mu0, work,
            numbers, plan.tolerance, counts, history, xi, kick, missing, room,
        )  # fmt: skip
        if code == SOLVED and not within_reach(layout, chart, work[rows(XI, d)], xi):
            code = DIVERGED
        if code == SOLVED:
            for i in range(d):
                numbers[i] += missing[i]
            add_late(h, factors, missing, xi)
            if not finish(layout, chart, xi, kick, numbers, saved, state):
                code = NOT_FINITE
                copy_into(state, saved)
        if code != SOLVED:
            copy_rows(stages, before)
            return code
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, saved[0], state[0], state[1])
        if kept.bases.shape[0] > 0:
            curve_of(fit, eta, kept.curves[step])
        watch_stages(plan, kept, step, r + d, velocity, s)
    copy_rows(stages, velocity)
    return SOLVED


@cache
def compiled_advance_group_law():
    """``advance_group_law`` compiled or cached, one kernel for all groups and laws."""
    whole = types.int64
    signature = whole(
        types.int64[::1], types.int64[:, ::1], whole, VECTOR, TABLES, PLAN, whole, PROGRESS, MATRIX,
        VECTOR, MATRIX, KEPT,
    )  # fmt: skip
    return compiled_for(advance_group_law, signature, jit_inline)
