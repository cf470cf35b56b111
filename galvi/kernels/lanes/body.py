"""Many steps of a rigid body in vector instructions, as galvi.kernels.on_group.

If the rule has as many points s as a curve has coefficients per component, the stage equations of
galvi.kernels.on_group.stages are those of collocation in the chart, with eta and f from xi and pi
(galvi.kernels.lanes.body_formulas):

    xi_j = h sum_k A_jk eta_k,     xi(1) = h sum_k b_k eta_k,
    pi_j = p0 + h sum_k B_jk f_k,  p1 = p0 + h sum_k b_k f_k = T(xi(1))^T mu1,
    mu1 = Phi(xi(1))^T (mu0 + h sum_k b_k n_k)

p0 would be mu0 if the base point of the chart were fixed; it differs by the error of a step. The
equations are solved by fixed-point iteration; a step for which that fails, or whose |xi| exceeds
REACHES, is left to the general kernel.

state           (4, 12)   as in galvi.kernels.on_group.advance
moves           (2 s, P)  h A^T and its low part; P as in galvi.kernels.lanes.nbody
turns           (2 s, P)  h B^T and its low part
kicks           (2, s)    h b and its low part
ahead           (l s, P)  for r = 1 .. l: extrapolation of velocities that keeps r Legendre terms
series, growth            as in galvi.kernels.lanes.nbody
fit             (m, s)    h times the coefficients of a curve from its rates at the stages
body            (33,)     see galvi.kernels.lanes.body_formulas; mass g at 21 to 23 is updated here,
                          from 24 on it is scratch
weight          (3,)      mass g in space
work            (36, P)   xi, pi, [eta, f, n, velocity], -, guess, zeros, low parts of xi and of pi
spare           (6, P)    scratch
solver_state    (4,)      as in galvi.kernels.on_group.advance, then the number of Legendre terms
                          extrapolated
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.array_types import MATRIX, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit_inline
from galvi.kernels.lanes.body_formulas import stage_forces, stage_momenta, stage_rates
from galvi.kernels.lanes.gravity import LANES, combine, move
from galvi.kernels.lanes.law import curve_of
from galvi.kernels.lanes.nbody import RECONSIDER, choose_terms, copy_rows
from galvi.kernels.lie.chart_functions import REACHES
from galvi.kernels.lie.groups import so3
from galvi.kernels.lie.rotations import change, inverse_tangent
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import (
    DIVERGED,
    FIXED_POINT_PASSES,
    FORCES,
    GOING,
    ITERATIONS,
    SOLVED,
    reset_history,
    verdict,
)
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, record

BODY_TABLES = types.Tuple((FIXED_MATRIX,) * 5 + (FIXED_VECTOR, FIXED_MATRIX))
TERMS = 3  # index in solver_state
PULLS = 2  # corrections of an initial guess by the chart's tangent map
AXES = (0, 0, 0)
NEAR = 1e-4  # relative change of the stages below which the error of p0 is evaluated
SURE = 3.0  # least ratio of the error of p0 to the last change for p0 to be corrected
LEAST = 3e-16  # largest relative error of p0 that is accepted
PATIENCE = 4.0  # growth of that limit from one attempt at convergence to the next


@jit_inline
def momentum_scale(kicks, mu0, f):
    """1 over the largest momentum or impulse of a step, which may start at rest; 0 if all are 0."""
    h, size = 0.0, max(abs(mu0[0]), abs(mu0[1]), abs(mu0[2]))
    for j in range(kicks.shape[1]):
        h += kicks[0, j]
    for i in range(3):
        for j in range(kicks.shape[1]):
            size = max(size, abs(h * f[i, j]))
    return 1.0 / size if size > 0.0 else 0.0


@jit_inline
def end_defect(chart, kicks, results, mu0, p0, size, out):
    """out <- rows xi(1), h sum_k b_k n_k, and the error of p0; returns size times the last.

    In the frame of the step's start, p0 gives the final momentum Phi T^-T (p0 + h sum_k b_k f_k),
    which should be mu0 + h sum_k b_k n_k.
    """
    for i in range(3):
        place, force, kick = 0.0, 0.0, 0.0
        for j in range(kicks.shape[1]):
            place += kicks[1, j] * results[i, j]
            force += kicks[1, j] * results[3 + i, j]
            kick += kicks[1, j] * results[6 + i, j]
        for j in range(kicks.shape[1]):
            place += kicks[0, j] * results[i, j]
            force += kicks[0, j] * results[3 + i, j]
            kick += kicks[0, j] * results[6 + i, j]
        out[0, i], out[1, i], out[2, i] = place, kick, p0[i] + force
    xi, momentum = (out[0, 0], out[0, 1], out[0, 2]), (out[2, 0], out[2, 1], out[2, 2])
    body = inverse_tangent(chart, -1.0, xi, momentum)
    swung = change(chart, 1.0, xi, body)
    for i in range(3):
        out[2, i] = (mu0[i] - body[i]) + (out[1, i] - swung[i])
    return size * max(abs(out[2, 0]), abs(out[2, 1]), abs(out[2, 2]))


@jit_inline
def relax(charts, weights, moves, turns, kicks, body, mu0, p0, work, spare, tolerance, counts,
          history):  # fmt: skip
    """Fixed-point iteration from xi and pi in work until convergence; returns a code.

    p0            momentum at the start in the chart, corrected during the iteration
    spare[0:3]    <- xi(1), the impulse of the forces, and the last correction of p0

    The error of p0 is known to about the last change of the stages, and each correction costs some
    passes: it is made when it exceeds SURE times that change, and at the end.
    """
    stages, padded = kicks.shape[1], moves.shape[1]
    xi, pi, eta, f, nothing = work[0:3], work[3:6], work[6:9], work[9:12], work[27:30]
    xi_low, pi_low = work[30:33], work[33:36]
    results, origin, chart = work[6:18], work[27], len(charts) - 1
    near, last, least, size = NEAR, np.inf, LEAST, 0.0
    reset_history(history)
    for passes in range(FIXED_POINT_PASSES):
        for chunk in range(padded // LANES):
            stage_forces(charts, weights, body, xi, pi, results, padded, chunk)
        if passes == 0:
            size = momentum_scale(kicks, mu0, f)
            for chunk in range(padded // LANES):
                combine(AXES, moves, stages, eta, xi_low, 0, stages, padded, chunk)
                combine(AXES, turns, stages, f, pi_low, 0, stages, padded, chunk)
        if last <= near:
            missing = end_defect(chart, kicks, results, mu0, p0, size, spare)
            near = missing / SURE
            if near > last:
                for i in range(3):
                    p0[i] += spare[2, i]
                near = last / SURE
                reset_history(history)
        change = 0.0
        for chunk in range(padded // LANES):
            change = move(AXES, moves, 0, eta, nothing, xi_low, origin, xi, change, 1.0, 0, stages,
                          padded, chunk)  # fmt: skip
            change = move(AXES, turns, 0, f, nothing, pi_low, p0, pi, change, size, 0, stages,
                          padded, chunk)  # fmt: skip
        last = change
        counts[ITERATIONS] += 1
        counts[FORCES] += stages
        code = verdict(change, tolerance, history)
        if code == SOLVED:
            missing = end_defect(chart, kicks, results, mu0, p0, size, spare)
            if missing > least:
                for i in range(3):
                    p0[i] += spare[2, i]
                near, least = 0.0, PATIENCE * least
                code = GOING
                reset_history(history)
        if code != GOING:
            return code
    return DIVERGED


@jit_inline
def start(charts, moves, body, stages, guess, work):
    """xi and pi from guessed velocities, by a few iterations of xi' = T^-1 velocity."""
    padded = moves.shape[1]
    xi, pi, eta = work[0:3], work[3:6], work[6:9]
    for chunk in range(padded // LANES):
        combine(AXES, moves, 0, guess, xi, 0, stages, padded, chunk)
    for _pull in range(PULLS):
        for chunk in range(padded // LANES):
            stage_rates(charts, xi, guess, eta, padded, chunk)
        for chunk in range(padded // LANES):
            combine(AXES, moves, 0, eta, xi, 0, stages, padded, chunk)
    for chunk in range(padded // LANES):
        stage_momenta(charts, body, xi, guess, pi, padded, chunk)


@jit_inline
def within_reach(chart, xi, end):
    """Whether all stages and the end are within REACHES of the chart."""
    farthest = end[0] * end[0] + end[1] * end[1] + end[2] * end[2]
    for k in range(xi.shape[1]):
        square = xi[0, k] * xi[0, k] + xi[1, k] * xi[1, k] + xi[2, k] * xi[2, k]
        farthest = max(farthest, square)
    return farthest <= REACHES[chart] * REACHES[chart]


@jit_inline
def advance_body(charts, weights, tables, body, weight, plan, todo, progress, work, spare, kept):
    """Do ``todo`` more steps; returns a code. A step that fails is not done."""
    plan, kept = Plan(*plan), Kept(*kept)
    moves, turns, kicks, ahead, series, growth, fit = tables
    state, stages, solver_state, counts, _passage = progress
    s, padded = kicks.shape[1], moves.shape[1]
    velocity, guess, terms = work[15:18], work[24:27], solver_state[TERMS:]
    chart, mu0, p0, history, R = len(charts) - 1, spare[3], spare[4], spare[5], body[24:]
    copy_rows(velocity, stages)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for i in range(3):
            mu0[i] = state[1, i]
            p0[i] = mu0[i] + state[1, 3 + i]
            body[21 + i] = 0.0
            for j in range(3):
                body[21 + i] += state[0, 3 * j + i] * weight[j]
        if solver_state[HOLDS] == LAST_STEP:
            if (plan.first + step) % RECONSIDER == 0 or terms[0] == 0:
                choose_terms(AXES, series, growth, velocity, guess, terms, spare[0])
            for chunk in range(padded // LANES):
                combine(AXES, ahead, (terms[0] - 1) * s, velocity, guess, 0, s, padded, chunk)
        else:
            for i in range(3):
                for k in range(padded):
                    guess[i, k] = velocity[i, min(k, s - 1)]
        copy_rows(stages, velocity)
        start(charts, moves, body, s, guess, work)
        code = relax(charts, weights, moves, turns, kicks, body, mu0, p0, work, spare,
                     plan.tolerance, counts, history)  # fmt: skip
        xi = spare[0]
        if code == SOLVED and not within_reach(chart, work[0:3], xi):
            code = DIVERGED
        if code != SOLVED:
            return code
        for i in range(3):  # remaining error of p0, to first order
            p0[i] += spare[2, i]
            for j in range(3):
                xi[i] += plan.step * body[3 * i + j] * spare[2, j]
        for i in range(9):
            R[i] = state[0, i]
        so3.advance(chart, xi, state[0], state[2], state[3, 3:])
        so3.carry(chart, R, state[0], xi, spare[1], state[1], state[1, 6:], state[3])
        for i in range(3):
            state[1, 3 + i] = p0[i] - mu0[i]
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, R, state[0], state[1])
        if kept.bases.shape[0] > 0:
            curve_of(fit, work[6:9], kept.curves[step])
    copy_rows(stages, velocity)
    return SOLVED


@cache
def compiled_advance_body(chart, weight):
    """``advance_body`` compiled or cached for a chart's number, and a weight (1) or none (0)."""
    whole = types.int64
    signature = whole(
        types.UniTuple(whole, 1 + chart), types.UniTuple(whole, 1 + weight), BODY_TABLES, VECTOR,
        VECTOR, PLAN, whole, PROGRESS, MATRIX, MATRIX, KEPT,
    )  # fmt: skip
    return compiled_for(advance_body, signature, jit_inline)
