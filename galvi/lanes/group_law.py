"""Many steps of a Lagrangian on a Lie group in vector instructions, as galvi.kernels.on_group.

With A and B those of galvi.lanes.law, rates eta and forces f in the chart at the step's
start, and n and mu as in galvi.kernels.on_group.stages, the stage equations are

    xi_j = h sum_k A_jk eta_k,                       xi(1) = h sum_k b_k eta_k,
    pi_j = p0 + h sum_k B_jk f_k + sum_l m_l Y_lj,   p1 = p0 + h sum_k b_k f_k = T(xi(1))^T mu1,
    mu1 = Ad*_{Phi(xi(1))} (mu0 + h sum_k b_k n_k),  sum_j b_j Y_lj eta_j = 0

p0 would be mu0 if the base point of the chart were fixed; it differs by the error of a step. With
more points than coefficients, rates of curves are orthogonal to the functions Y_l, and a multiplier
m_l is the momenta's part along Y_l. With the momenta in the frame of the step's start and their
pull-back

    nu_j = mu0 + h sum_k B_jk n_k,   Q_j = T(xi_j)^T Ad*_{Phi(xi_j)} nu_j = T(-xi_j)^T nu_j

and Q(1) at the step's end, pi_j = Q_j + D_j, where the defect

    D_j = Q(1) - Q_j + h sum_k (B_jk - b_k) f_k + sum_l m_l Y_lj

is the error of the rule for the rate of Q along a curve: as small as that of a step, and as little
changed by errors of the curve. A pass of the iteration takes n from xi, momenta T^-T (Q + D) with
the last D, velocities from these by one Newton step with the last mass, their rates eta, projected
to those of curves, f from the last xi and eta with these momenta, and from eta and f the next xi, D
and multipliers; p0 is not an unknown. A step for which that does not converge, or whose rotation
exceeds REACHES, is left to the general kernel.

The iteration is done after the passes that its rate asks for. Changes of about a rounding error say
nothing of what is still missing, and a pass that is not needed costs as much as any other. So the
rate is taken from the changes above CLEAR, and the passes that it asks for below are counted down.

law           address of the law's galvi.lanes.group_pass
given         its argument
layout, chart           as in galvi.kernels.lie.product
state, solver_state     as in galvi.kernels.on_group.advance; solver_state[3] is the number of
                        Legendre terms extrapolated
work, numbers  as in galvi.lanes.group_rows
series        (s, P)    Legendre coefficients from stages, transposed
growth        (l,)      Legendre polynomials at the next step's end
fit           (m, s)    h times the coefficients of a curve from its rates at the stages
c             (P,)      nodes
history       (HISTORY,) of which the first four are those of galvi.kernels.nystrom.solve.decide;
              the last known change, times the rate at each pass; that rate; OVER changes, the
              newest first
spare         (6, at least HISTORY, P and the width of state)  scratch, and the state before a step
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline, jit_noalloc
from galvi.kernels.lie import product
from galvi.kernels.lie.arithmetic import generic, in_kernels, larger, where
from galvi.kernels.lie.dispatch import REACHES
from galvi.kernels.lie.elementary import sqrt
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR, copy_into
from galvi.kernels.run_record import KEPT as KEPT_ARRAYS
from galvi.kernels.run_record import PLAN, PROGRESS, Kept, Plan, record
from galvi.lanes import group_rows as blocks
from galvi.lanes.group_pass import AHEAD, BEGIN, FINISH, LOW, PASS, PREPARE, SIZES
from galvi.lanes.law import TERMS, curve_of, outgrows, terms_of, watch_stages
from galvi.lanes.nbody import RECONSIDER, copy_rows

HISTORY = 10  # numbers of history
REST_CHANGE, RATE, CHANGES = 4, 5, 6  # indices there
OVER = 4  # changes kept: errors oscillate, and the rate of convergence is a mean
FAR_FROM_SOLVED = 1e4  # changes so many times larger than the tolerance are not looked at closely
SOON = 1e-11  # relative change from which on the remaining passes are counted
CLEAR = 3e-15  # relative change that is not round-off
# Relative change that may be slow convergence, if SLOW_PASSES passes lessen it.
SLOW_CONVERGENCE = 1e-13
SLOW_PASSES = 12.0  # without a smaller change, after which convergence has ended


@generic
def begin_countdown(history):
    """Set history to its initial values."""
    solve.reset_history(history)
    history[REST_CHANGE], history[RATE] = np.inf, 0.5
    for k in range(CHANGES, CHANGES + OVER):
        history[k] = np.inf


@generic
def rate_of(change, last, second, first):
    """The mean rate since the first of OVER changes, or a careful guess from fewer; 0 if none."""
    guess = where(second < np.inf, larger(change / last, last / second), sqrt(change / last))
    return where(first < np.inf, sqrt(sqrt(change / first)), guess)


def number_is_true(condition):
    """Whether a comparison of numbers is true."""
    return condition


@in_kernels(number_is_true)
def is_true(condition):
    """Whether a comparison of numbers is true; of lanes it is not known."""
    return not hasattr(condition, "select") and number_is_true(condition)


@generic
def count_down(change, tolerance, history):
    """GOING, SOLVED, DIVERGED or NOT_FINITE after a pass with this largest relative change; also
    in lanes."""
    last, second, third, first = history[6], history[7], history[8], history[9]
    history[6], history[7], history[8], history[9] = change, last, second, third
    quick = (
        (change > larger(FAR_FROM_SOLVED * tolerance, SOON))
        & (change < 0.5 * last)
        & (last < np.inf)
    )
    if is_true(quick):
        history[0] = change
        return solve.GOING
    rate, kept = (
        history[RATE],
        (history[1], history[2], history[3], history[REST_CHANGE], history[RATE]),
    )
    code, rest = solve.decide(change, tolerance, history), history[REST_CHANGE] * rate
    left = rest * rate - tolerance * (1.0 - rate)  # above 0 where a further pass is needed
    solved, least, idle = code < solve.NOT_FINITE, history[2], history[3]
    # a rate may be small by chance, and some parts lag
    once_more = solved & (idle < solve.IDLE) & (tolerance < CLEAR) & (left > 0.0)
    patient = solved & (least > SLOW_CONVERGENCE) & (idle >= solve.IDLE) & (idle < SLOW_PASSES)
    rest, code = where(once_more, 0.0, rest), where(once_more | patient, solve.GOING, code)
    unknown = (change <= CLEAR) | (change >= SOON)
    if not is_true(unknown):
        new = rate_of(change, last, second, first)
        unknown = unknown | (new <= 0.0) | (new >= 1.0)
        left = where(unknown, left, change * new - tolerance * (1.0 - new))
        rest, rate = where(unknown, rest, change), where(unknown, rate, new)
    code = where((code > solve.DIVERGED) & (left <= 0.0), solve.SOLVED, code)
    history[REST_CHANGE], history[RATE] = rest, rate
    for k in range(5):
        history[k + 1] = where(quick, kept[k], history[k + 1])
    return where(quick, solve.GOING, code)


judged = jit_inline(count_down)


GROUP_TABLES = types.Tuple((FIXED_MATRIX, FIXED_VECTOR, FIXED_MATRIX, FIXED_VECTOR))


@jit_inline
def rows(block, d):
    """The rows of a block of work."""
    return slice(block * d, (block + 1) * d)


@jit_inline
def relax(law, given, stages, d, numbers, tolerance, counts, history):
    """Passes from the xi and eta in work until convergence; returns a code."""
    begin_countdown(history)
    settled = False
    for passes in range(solve.FIXED_POINT_PASSES):
        change = do(PASS, law, given, numbers, d)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += stages
        if passes == 0:  # the sizes of a motion from rest are known after it
            do(SIZES, law, given, numbers, d)
            continue
        code = judged(change, tolerance, history)
        if not settled and solve.close_enough(change, tolerance):
            settled = True
            do(LOW, law, given, numbers, d)
        elif code != solve.GOING:
            return code
    return solve.DIVERGED


@jit_inline
def do(part, law, given, numbers, d):
    """Do one part of galvi.lanes.group_pass; returns the change it notes."""
    numbers[3 * d + blocks.PART] = part
    call_void(law, given)
    return numbers[3 * d + blocks.CHANGE]


@jit_noalloc
def finish(layout, chart, xi, kick, before, state):
    """The state at the step's end from that before; returns whether it is finite."""
    d, total = xi.size, 0.0
    r = state.shape[1]
    entries = 0
    for factor in range(layout.shape[0]):
        entries += layout[factor, 2]
    g, mu = state[0, :entries], state[1, :d]
    product.advance(layout, chart, xi, g, state[2, :entries], state[3, d : d + entries])
    product.carry(layout, chart, before[0], g, xi, kick, mu, state[1, 2 * d : 3 * d], state[3, :d])
    for i in range(r):
        total += abs(state[0, i]) + abs(state[1, i])
    return total < np.inf


@jit_inline
def advance_group_law(law, given, layout, chart, tables, plan, todo, progress, work, numbers,
                      spare, kept):  # fmt: skip
    """Do ``todo`` more steps; returns a code. A step that fails is not done."""
    plan, kept = Plan(*plan), Kept(*kept)
    series, growth, fit, c = tables
    state, stages, solver_state, counts, _passage = progress
    (d, s), r, h = stages.shape, kept.q.shape[1], plan.step
    velocity, before, eta = (
        work[rows(blocks.VELOCITY, d)],
        work[rows(blocks.BEFORE, d)],
        work[rows(blocks.ETA, d)],
    )
    xi, kick, times = (
        work[blocks.END * d : (blocks.END + 1) * d, 0],
        work[blocks.PULLED * d : (blocks.PULLED + 1) * d, 0],
        work[blocks.TIMES * d],
    )
    history, sizes, saved = spare[0], spare[1], spare[2:6, : state.shape[1]]
    numbers[3 * d + blocks.PLACE + r] = h
    do(PREPARE, law, given, numbers, d)
    for i in range(d):
        for k in range(velocity.shape[1]):
            before[i, k] = velocity[i, k] = stages[i, min(k, s - 1)]
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for k in range(times.size):
            times[k] = plan.t0 + ((plan.first + step) + c[k]) * h
        for i in range(d):
            numbers[i] = state[1, i]
        for i in range(r):
            numbers[3 * d + blocks.PLACE + i] = state[0, i]
        if solver_state[HOLDS] == LAST_STEP:
            if (plan.first + step) % RECONSIDER == 0 or solver_state[TERMS] == 0:
                solver_state[TERMS] = terms_of(
                    series, growth, velocity, work[rows(blocks.F, d)], sizes
                )
            numbers[3 * d + blocks.KEPT] = solver_state[TERMS]
            do(AHEAD, law, given, numbers, d)
            if outgrows(velocity, before):
                copy_rows(velocity, before)
                solver_state[TERMS] = terms_of(
                    series, growth, velocity, work[rows(blocks.F, d)], sizes
                )
                numbers[3 * d + blocks.KEPT] = solver_state[TERMS]
                do(AHEAD, law, given, numbers, d)
        copy_into(saved, state)
        do(BEGIN, law, given, numbers, d)
        code = relax(law, given, s, d, numbers, plan.tolerance, counts, history)
        if code == solve.SOLVED:
            farthest = do(FINISH, law, given, numbers, d)
            reach = REACHES[chart]
            if not (farthest <= reach * reach and product.largest_rotation(layout, xi) <= reach):
                code = solve.DIVERGED
            elif not finish(layout, chart, xi, kick, saved, state):
                code = solve.NOT_FINITE
                copy_into(state, saved)
        if code != solve.SOLVED:
            copy_rows(stages, before)
            return code
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, saved[0], state[0], state[1])
        if kept.bases.shape[0] > 0:
            curve_of(fit, eta, kept.curves[step])
        watch_stages(plan, kept, step, r + d, velocity, s)
    copy_rows(stages, velocity)
    return solve.SOLVED


@cache
def compiled_advance_group_law():
    """``advance_group_law`` compiled or cached, one kernel for all groups and laws."""
    whole = types.int64
    signature = whole(
        whole, whole, types.int64[:, ::1], whole, GROUP_TABLES, PLAN, whole, PROGRESS, MATRIX,
        VECTOR, MATRIX, KEPT_ARRAYS,
    )  # fmt: skip
    return compiled_for(advance_group_law, signature, jit_inline)
