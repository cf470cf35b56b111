"""Many steps of any Lagrangian on R^d, or of a canonical system, in vector instructions.

With weights b_j > 0, s points and m coefficients per component, the stage equations of
galvi.kernels.on_group.stages are

    q_j = q0 + h sum_k A_jk v_k,                q1 = q0 + h sum_k b_k v_k,
    p_j = p0 + h sum_k B_jk f_k + lambda_j,     p1 = p0 + h sum_k b_k f_k,
    C v = 0,   (1 - C) lambda = 0,

with p = dL/dv and f = dL/dq at the stages, an external force added to f. 1 - C projects onto the
slopes of the space's functions at the points, orthogonally in the rule's inner product
sum_j b_j x_j y_j; b_j B_jk + b_k A_kj = b_j b_k. If s = m, C = 0 and lambda = 0: collocation. Else
lambda has s - m free numbers. m is the largest number of coefficients of a component; one with
fewer has its own C, and the same A and B.

A pass of the iteration takes the forces from the last places and velocities, p - lambda from the
forces, velocities from one step for (1 - C) dL/dv = p - lambda with the last mass M = d2L/dv2, and
places from the velocities. That step is v += (1 - C) M^-1 (1 - C) (p - dL/dv): Newton's if s = m,
or if M is the same at all stages and couples only components with the same C; its error is of
second order in the differences of M between stages. A step for which the iteration does not
converge is left to the general kernel.

A canonical system without an external force iterates places ``alone``, by the Nystrom method of
galvi.tableau and galvi.kernels.nystrom.advance, as a law of unit mass: Q = q + c h v + h^2 A a(Q).

law           address of the law's galvi.lanes.law_pass
given         its argument
state         (4, n)    q, p and their low parts; alone: q, its low part, v and its low part
tables, complement, numbers, work  as in galvi.lanes.law_pass
kicks         (2, s)    h b and its low part; alone (s, P): h b, h^2 beta and their low parts
ahead         (l s, P)  for r = 1 .. l: extrapolation of velocities that keeps r Legendre terms;
                        alone: not read
series, growth          as in galvi.lanes.nbody
fit           (m, s)    h times the coefficients of a curve from its rates at the stages; alone
                        h^2 times those from accelerations
c             (P,)      nodes
line          (m,)      alone: h times the coefficients of a curve from the velocity
spare         (6, at least s, d and 4)  scratch, and the state before the step
solver_state  (4,)      as in galvi.kernels.on_group.advance, then the number of Legendre terms
                        extrapolated
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline
from galvi.kernels.forces.passages import near_limit, note_passages
from galvi.kernels.lie.arithmetic import two_sum
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR, copy_into, terms_to_extrapolate
from galvi.kernels.run_record import KEPT, PLAN, PROGRESS, Kept, Plan, record, watched_row
from galvi.lanes.gravity import LANES, NARROW_LANES, combine, combine_narrow
from galvi.lanes.law_pass import LOW_P, LOW_Q, first_of_steps
from galvi.lanes.nbody import RECONSIDER, copy_rows, end_of_step

FOUR, ONE = (0, 0, 0, 0), (0,)  # components that are gathered together
TERMS = 3  # index in solver_state
LARGEST_GUESS = 64.0  # over the velocities before, above which its terms are chosen anew
TABLES = types.Tuple(
    (FIXED_MATRIX,) * 3 + (MATRIX,) * 2 + (FIXED_VECTOR, FIXED_MATRIX) + (FIXED_VECTOR,) * 2
)  # kicks, ahead, series, moves and turns, complement; growth, fit, c, line
PASS_TYPE = types.void(types.int64)


@jit_inline
def inverse_size(places, h, rates):
    """1 over the largest |place| (d,) or |h rate| (d, P); 0 where all are 0."""
    size = 0.0
    for i in range(rates.shape[0]):
        size = max(size, abs(places[i]))
        for k in range(rates.shape[1]):
            size = max(size, abs(h * rates[i, k]))
    return 1.0 / size if size > 0.0 else 0.0


@jit_inline
def gather(matrix, start, stages, values, out):
    """out <- values (d, s) times the rows of the matrix from ``start`` on."""
    d, padded = out.shape
    together = d - d % len(FOUR) if padded % LANES == 0 else 0
    for chunk in range(padded // LANES):
        for block in range(together // len(FOUR)):
            combine(FOUR, matrix, start, values, out, block, stages, padded, chunk)
    for i in range(together, d):
        gather_row(matrix, start, stages, values, out, i)


@jit_inline
def gather_row(matrix, start, stages, values, out, i):
    """One row of `gather`."""
    padded = out.shape[1]
    if padded % LANES == 0:
        for chunk in range(padded // LANES):
            combine(ONE, matrix, start, values, out, i, stages, padded, chunk)
    else:
        for chunk in range(padded // NARROW_LANES):
            combine_narrow(ONE, matrix, start, values, out, i, stages, padded, chunk)


@jit_inline
def onto_slopes(complement, stages, V, outside):
    """V <- (1 - C) V, with C of each component; outside (d, P) is scratch."""
    apart = V.shape[1] if complement.shape[0] > V.shape[1] else 0
    for i in range(V.shape[0]):
        gather_row(complement, i * apart, stages, V, outside, i)
        for k in range(V.shape[1]):
            V[i, k] -= outside[i, k]


@jit_inline
def add_low_parts(tables, alone, stages, d, work):
    """Adds to the low parts of places and momenta what those of the tables make of the rates."""
    P, scratch = work.shape[1], work[first_of_steps(d) : first_of_steps(d) + d]
    for part in range(1, 2 if alone else 3):
        first = tables.shape[0] - P if alone else (2 * part - 1) * P
        gather(tables, first, stages, work[part * d : (part + 1) * d], scratch)
        low = work[(LOW_Q + part - 1) * d : (LOW_Q + part) * d]
        for i in range(d):
            for k in range(P):
                low[i, k] += scratch[i, k]


@jit_inline
def iterate(law, given, tables, alone, stages, h, state, work, numbers, tolerance, counts, history):
    """Passes from the stages in work until convergence; returns a code."""
    d = state.shape[1]
    Q, V, F, settled = work[0:d], work[d : 2 * d], work[2 * d : 3 * d], False
    solve.reset_history(history)
    numbers[2 * d + 2] = 0.0
    for passes in range(solve.FIXED_POINT_PASSES):
        call_void(law, given)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += stages
        if passes == 0 and numbers[2 * d] == 0.0:  # sizes are known after it, as from rest
            numbers[2 * d] = inverse_size(state[0], 1.0 if alone else h, Q if alone else V)
            if not alone:
                numbers[2 * d + 1] = inverse_size(state[1], h, F)
            continue
        code = solve.verdict(numbers[2 * d + 2], tolerance, history)
        if not settled and solve.close_enough(numbers[2 * d + 2], tolerance):
            settled = True
            add_low_parts(tables, alone, stages, d, work)
        elif code != solve.GOING:
            return code
    return solve.DIVERGED


@jit_inline
def complete(kicks, V, F, state):
    """The state at the step's end, with compensated sums; returns whether it is finite."""
    total = 0.0
    for i in range(V.shape[0]):
        way, kick = 0.0, 0.0
        for row in (1, 0):
            for j in range(kicks.shape[1]):
                way += kicks[row, j] * V[i, j]
                kick += kicks[row, j] * F[i, j]
        state[0, i], state[2, i] = two_sum(state[0, i], state[2, i] + way)
        state[1, i], state[3, i] = two_sum(state[1, i], state[3, i] + kick)
        total += abs(state[0, i]) + abs(state[1, i])
    return total < np.inf


@jit_inline
def terms_of(series, growth, V, out, sizes):
    """How many Legendre terms of the last velocities to extrapolate."""
    s = series.shape[0]
    gather(series, 0, s, V, out)
    for l in range(s):
        sizes[l] = 0.0
        for i in range(V.shape[0]):
            sizes[l] = max(sizes[l], abs(out[i, l]))
    return terms_to_extrapolate(sizes, growth)


@jit_inline
def outgrows(guess, before):
    """Whether a guess is far larger than the velocities (d, P) that it extrapolates.

    The number of terms was chosen some steps ago. A guess that rounding makes 1e10 times too large
    gives sizes by which any change is small: the iteration would end before it began.
    """
    size, largest = 0.0, 0.0
    for i in range(before.shape[0]):
        for k in range(before.shape[1]):
            size, largest = max(size, abs(before[i, k])), max(largest, abs(guess[i, k]))
    return not largest <= LARGEST_GUESS * size


@jit_inline
def curve_of(fit, rates, out):
    """out (d, m) <- coefficients of a step's curve from its rates (d, at least s) at the stages."""
    for i in range(out.shape[0]):
        for l in range(fit.shape[0]):
            coefficient = 0.0
            for j in range(fit.shape[1]):
                coefficient += fit[l, j] * rates[i, j]
            out[i, l] = coefficient


@jit_inline
def watch_stages(plan, kept, step, first, velocities, s):
    """Keep the velocities (d, at least s) at the stages of a watched step from column first on."""
    row = watched_row(plan, kept, step)
    if row >= 0 and kept.seen.shape[1] > first:
        for i in range(velocities.shape[0]):
            for j in range(s):
                kept.seen[row, first + i * s + j] = velocities[i, j]


@jit_inline
def begin_stages(tables, complement, s, state, work):
    """Places Q from velocities V; low parts are those of the state."""
    d = state.shape[1]
    Q, V = work[0:d], work[d : 2 * d]
    if complement.shape[0] > 0:
        onto_slopes(complement, s, V, Q)
    gather(tables, 0, s, V, Q)
    for i in range(d):
        for k in range(Q.shape[1]):
            Q[i, k] += state[0, i]
            work[LOW_Q * d + i, k], work[LOW_P * d + i, k] = state[2, i], state[3, i]


@jit_inline
def extrapolate(ahead, series, growth, before, solver_state, V, out, sizes):
    """V <- the last step's velocities extrapolated, with terms chosen anew where that outgrows
    them; ``out`` and ``sizes`` are scratch."""
    s = series.shape[0]
    gather(ahead, (solver_state[TERMS] - 1) * s, s, before, V)
    if outgrows(V, before):
        solver_state[TERMS] = terms_of(series, growth, before, out, sizes)
        gather(ahead, (solver_state[TERMS] - 1) * s, s, before, V)


@jit_inline
def end(kicks, alone, stages, h, V, F, state):
    """The state at the step's end; returns whether it is finite."""
    if alone:
        gather(kicks, 0, stages, V, F)
        return end_of_step(h, F, state)
    return complete(kicks, V, F, state)


@jit_inline
def keep(plan, kept, step, fit, line, V, saved, alone):
    """Keep the curve of a step from the state ``saved``, and its stages where it is watched."""
    d = V.shape[0]
    if kept.bases.shape[0] > 0:
        curve_of(fit, V, kept.curves[step])
        for i in range(d if alone else 0):
            for l in range(line.size):
                kept.curves[step, i, l] += line[l] * saved[2, i]
    if not alone:
        watch_stages(plan, kept, step, 2 * d, V, fit.shape[1])


@jit_inline
def advance_law(law, given, parts, alone, plan, todo, progress, work, numbers, spare, kept):
    """Do ``todo`` more steps; returns a code. A step that fails is not done."""
    plan, kept = Plan(*plan), Kept(*kept)
    kicks, ahead, series, tables, complement, growth, fit, c, line = parts
    state, stages, solver_state, counts, passage = progress
    (d, s), h, second = stages.shape, plan.step, 2 if alone else 1
    Q, V, F = work[0:d], work[d : 2 * d], work[2 * d : 3 * d]
    before, times = work[6 * d : 7 * d], work[7 * d]
    sizes, history, saved = spare[0], spare[1], spare[2:6, :d]
    numbers[4 * d + 3] = h
    copy_rows(V, stages)
    for i in range(d):
        for k in range(s, V.shape[1]):
            V[i, k] = V[i, s - 1]
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        for k in range(times.size):
            times[k] = plan.t0 + ((plan.first + step) + c[k]) * h
        size = 0.0
        for i in range(d):
            numbers[i], numbers[d + i] = state[0, i], state[second, i]
            numbers[2 * d + 3 + i], numbers[3 * d + 3 + i] = state[3 - second, i], state[3, i]
            size = max(size, abs(state[0, i]), abs(state[0, i] + h * state[second, i]))
            for k in range(V.shape[1]):
                before[i, k] = V[i, k]
        terms = 0
        if solver_state[HOLDS] == LAST_STEP:
            if (plan.first + step) % RECONSIDER == 0 or solver_state[TERMS] == 0:
                solver_state[TERMS] = terms_of(series, growth, before, Q, sizes)
            if not alone:
                extrapolate(ahead, series, growth, before, solver_state, V, Q, sizes)
            terms = solver_state[TERMS]
        numbers[2 * d], numbers[2 * d + 1] = 0.0, 0.0
        if alone:
            numbers[2 * d], numbers[2 * d + 2] = 1.0 / size if size > 0.0 else 0.0, -1.0 - terms
            call_void(law, given)
        else:
            begin_stages(tables, complement, s, state, work)
        copy_into(saved, state)
        code = iterate(
            law, given, tables, alone, s, h, state, work, numbers, plan.tolerance, counts, history
        )
        if code == solve.SOLVED and not end(kicks, alone, s, h, V, F, state):
            code = solve.NOT_FINITE
        if code != solve.SOLVED:
            copy_into(state, saved)
            copy_rows(stages, before)
            return code
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, kept, step, saved[0], state[0], state[second])
        keep(plan, kept, step, fit, line, V, saved, alone)
        if passage.size > 0:
            fast, slow = near_limit(passage, V[:, 0], h, fit.shape[0])
            note_passages(
                passage, Q, c[:s], saved[0], state[0], h, fit.shape[0],
                max(fast, slow ** (2.0 / 3.0)), plan.first + step + 1,
            )  # fmt: skip
    copy_rows(stages, V)
    return solve.SOLVED


@cache
def compiled_advance_law():
    """``advance_law`` compiled or cached, one kernel for all laws."""
    whole = types.int64
    signature = whole(
        whole, whole, TABLES, types.boolean, PLAN, whole, PROGRESS, MATRIX, VECTOR, MATRIX, KEPT
    )
    return compiled_for(advance_law, signature, jit_inline)
