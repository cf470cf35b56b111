"""Many steps of Gauss collocation in a frame that moves with an integrable flow.

The system's Hamiltonian is A + B(q), where the flow phi of A is known. In the frame centred at the
middle of a step, z = phi_t(w) with t the time since then, and w' = D phi_-t(z) (0, -dB/dq): w
changes slowly and little. A step solves W_j = w + sum_l A_jl k_l, k_j = weight_j w'(W_j, t_j), sets
w <- w + sum_j b_j k_j and moves on to the next centre, w <- phi_h(w).

n is the number of rows for positions in the frame, and that for velocities; the problem has d
coordinates; s stages are padded to P, a multiple of LANES.

functions  (3,)    addresses of the frame's RATES, DRIFT and LEAVE
numbers    (c,)    their constants; the first is h
state      (8, m)  q, its low part, v and its low part at the end of the last step whose end was
                   computed; then the same in the frame: at the problem's start, or, after a step,
                   at the centre of the next one; m >= d and n
tables     A^T (s, P); b (P,), 0 after the last stage; c (P,); coefficients of a curve from slopes,
           transposed (s, m); clock (3,), see `place_nodes`, with eccentricity -1 for equal weights;
           inverse sizes of the rows (2 n,); checks (4,); coarse
checks     (4,)    the usual number of passes of a step; the relative change of W before the last of
                   these above which further passes follow; the error that these may leave; and the
                   last change, which is set
coarse     for the first pass, whose states are all the same: at s' nodes, fewer than s, their
           matrix to the stages (s', P), weights (P',) and positions (P',), and the values (s', P)
           of their polynomials at the stages, by which guesses are interpolated; s' is 0 if the
           first pass is done at all nodes
nodes      (5, P)  times, times since the step's centre and weights dt/dc, which are set; positions
                   of the nodes in [-1, 1] and their slopes, which are read
spare      (8, m)  scratch
path       (m + 1, s + 2) positions at a step's start, stages and end; the last row holds the
           fractions of the step at these, of which the last is not set here
solver_state  (3,) see galvi.kernels.nystrom.advance
"""

from __future__ import annotations

from functools import cache

from numba import types

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, REAL, VECTOR, compiled_for, jit_inline
from galvi.kernels.forces.passages import may_pass, note_paths
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP, NOTHING
from galvi.kernels.nystrom.solve import DIVERGED, FORCES, ITERATIONS, NOT_FINITE, SOLVED
from galvi.kernels.run_record import PLAN, PROGRESS, RECORDING, Plan, Recording, record, watched_row
from galvi.lanes.frames.rows import (
    ECCENTRICITY,
    OFFSET,
    TIME,
    WEIGHT,
    add_rows,
    interpolate_rows,
    place_nodes,
    place_rows,
    spread_rows,
)

# (numbers, nodes, W, work, guess, k, pass): k <- weight times w' at the stages W. work (.., LANES)
# is scratch for eight stages; guess (.., P) is the guess that each pass leaves for the next; the
# first pass is number 0.
RATES = types.void(VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, REAL)
# (numbers, share, state): moves rows 4 to 7 of the state by the flow phi over ``share`` steps,
# |share| <= 1.
DRIFT = types.void(VECTOR, REAL, MATRIX)
# (numbers, state): sets rows 0 to 3 of the state from rows 4 to 7.
LEAVE = types.void(VECTOR, MATRIX)
COARSE = types.Tuple((MATRIX, VECTOR, VECTOR, MATRIX))
TABLES = types.Tuple((MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, VECTOR, VECTOR, COARSE))
STAGES = types.UniTuple(MATRIX, 4)
WORK = types.Tuple((STAGES, STAGES, MATRIX, MATRIX, MATRIX))
MAX_PASSES = 60
PASSES, ALARM_CHANGE, ALLOWED_REST, CHANGE = range(4)
MAX_FURTHER_PASSES = 2  # after the usual ones; then a step has failed
LARGEST_FINITE_CHANGE = 1e300
ROUNDING_CHANGE = 2.0**-48  # relative change of W that may be round-off
# Largest ratio of two successive changes for which further passes are worth their time.
LARGEST_CONTRACTION = 0.5


@jit_inline
def solve_step(functions, numbers, tables, state, counts, stages, coarse_stages, work):
    """Set k at the solution of a step's equations; returns a code.

    The usual number of passes is done. If the change of W before the last of them is above
    ALARM_CHANGE, up to MAX_FURTHER_PASSES more follow (for a negative ALARM_CHANGE, as many as are
    needed), until the error is at most ALLOWED_REST: if changes shrink by a ratio r, the slopes at
    the last W err by about r^2 times its change.
    """
    matrix, b, c, fit, clock, sizes, checks, coarse = tables
    W, k, nodes, guess = stages
    s, last, change, first = matrix.shape[0], 0.0, 0.0, 1
    usual_passes = int(checks[PASSES])
    spread_rows(state[4], state[6], W)
    if coarse[0].shape[0] > 0:
        few_W, few_k, few_nodes, few_guess = coarse_stages
        spread_rows(state[4], state[6], few_W)
        call_void(functions[0], numbers, few_nodes, few_W, work, few_guess, few_k, 0.0)
        interpolate_rows(coarse[3], few_guess, guess)
        counts[ITERATIONS] += 1
        counts[FORCES] += coarse[0].shape[0]
        change = place_rows(coarse[0], few_k, state[4], state[6], W, sizes, usual_passes <= 2)
        first = 2
    for passes in range(first, MAX_PASSES + 1):
        call_void(functions[0], numbers, nodes, W, work, guess, k, float(passes - 1))
        counts[ITERATIONS] += 1
        counts[FORCES] += s
        checks[CHANGE] = change
        if passes == usual_passes and change <= checks[ALARM_CHANGE]:
            return SOLVED
        if passes > usual_passes:
            if (
                change <= ROUNDING_CHANGE
                or change * change * change <= checks[ALLOWED_REST] * last * last
            ):
                return SOLVED
            if not change < LARGEST_FINITE_CHANGE:
                return NOT_FINITE
            if passes >= usual_passes + MAX_FURTHER_PASSES and checks[ALARM_CHANGE] >= 0.0:
                return DIVERGED
            if passes > 4 and change > LARGEST_CONTRACTION * last:
                return DIVERGED
        last = change
        change = place_rows(matrix, k, state[4], state[6], W, sizes, passes >= usual_passes - 1)
    return DIVERGED


@jit_inline
def leave_at(functions, numbers, share, state, spare):
    """Set rows 0 to 3 of ``spare`` to q and v and their low parts, ``share`` steps after w, which
    is in rows 4 to 7 of the state."""
    for row in range(4, 8):
        for i in range(state.shape[1]):
            spare[row, i] = state[row, i]
    if share != 0.0:
        call_void(functions[1], numbers, share, spare)
    call_void(functions[2], numbers, spare)


@jit_inline
def fill_path(functions, numbers, h, state, spare, W, nodes, path):
    """Set the columns of ``path`` to q at the start of a step and at its stages W; the last row to
    the fractions of the step at these."""
    n = W.shape[0] // 2
    for column in range(path.shape[1]):
        share = nodes[OFFSET, column - 1] / h if column > 0 else -0.5
        leave_at(functions, numbers, 0.0, state, spare)
        for i in range(n):
            if column > 0:
                spare[4, i], spare[5, i] = W[i, column - 1], 0.0
                spare[6, i], spare[7, i] = W[n + i, column - 1], 0.0
        call_void(functions[1], numbers, share, spare)
        call_void(functions[2], numbers, spare)
        for i in range(path.shape[0] - 1):
            path[i, column] = spare[0, i]
        path[path.shape[0] - 1, column] = share + 0.5


@jit_inline
def leave(functions, numbers, state, spare, d):
    """Set rows 0 to 3 of the state at the step's end, from w at its centre in rows 4 to 7.

    Returns False if q or v would not be finite; the rows are then unchanged.
    """
    leave_at(functions, numbers, 0.5, state, spare)
    total = 0.0
    for i in range(d):
        total += abs(spare[0, i]) + abs(spare[2, i])
    if not total < LARGEST_FINITE_CHANGE:
        return False
    for row in range(4):
        for i in range(d):
            state[row, i] = spare[row, i]
    return True


@jit_inline
def set_nodes(plan, clock, number, b, c, nodes):
    """Set the times, the times since the step's centre and the weights of the nodes c of a step."""
    for j in range(nodes.shape[1]):
        nodes[TIME, j] = plan.t0 + (number + c[j]) * plan.step
    if clock[ECCENTRICITY] >= 0.0:
        place_nodes(clock, float(number), plan.step, b, nodes)
    else:
        for j in range(nodes.shape[1]):
            nodes[OFFSET, j], nodes[WEIGHT, j] = (c[j] - 0.5) * plan.step, plan.step


@jit_inline
def advance_frame(functions, numbers, tables, plan, todo, progress, scratch, recording):
    """Do ``todo`` more steps of a run; returns a code, as galvi.kernels.nystrom.advance.

    A step that fails leaves no valid state.
    """
    plan, recording = Plan(*plan), Recording(*recording)
    matrix, b, c, fit, clock, sizes, checks, coarse = tables
    state, _stages, solver_state, counts, passage = progress
    stages, coarse_stages, work, spare, path = scratch
    W, k, nodes, _guess = stages
    n, d = W.shape[0] // 2, recording.q.shape[1]
    if solver_state[HOLDS] == NOTHING:
        call_void(functions[1], numbers, 0.5, state)
        solver_state[HOLDS] = LAST_STEP
    first = solver_state[DONE]
    for step in range(first, first + todo):
        number = plan.first + step
        if coarse[0].shape[0] > 0:
            set_nodes(plan, clock, number, coarse[1], coarse[2], coarse_stages[2])
        set_nodes(plan, clock, number, b, c, nodes)
        code = solve_step(functions, numbers, tables, state, counts, stages, coarse_stages, work)
        if code != SOLVED:
            return code
        if recording.bases.shape[0] > 0:
            record_curve(state, fit, k, recording.bases[step], recording.curves[step])
        may_be_passage = False
        if passage.size > 0:
            leave_at(functions, numbers, 0.0, state, spare)
            may_be_passage = may_pass(passage, spare[0], spare[2], plan.step, matrix.shape[0])
        if may_be_passage:
            fill_path(functions, numbers, plan.step, state, spare, W, nodes, path[:, :-1])
        add_rows(b, k, state[4], state[5], 0, n)
        add_rows(b, k, state[6], state[7], n, n)
        if may_be_passage:
            leave_at(functions, numbers, 0.5, state, spare)
            for i in range(d):
                path[i, path.shape[1] - 1] = spare[0, i]
            note_paths(passage, path, plan.step, matrix.shape[0], number + 1)
        row, remainder = divmod(step + 1, plan.save_every)
        if (
            remainder == 0
            or step + 1 == first + todo
            or step + 1 == plan.total
            or watched_row(plan, recording, step) >= 0
        ):
            if not leave(functions, numbers, state, spare, d):
                return NOT_FINITE
            record(
                plan,
                Recording(
                    recording.q,
                    recording.p,
                    recording.bases[:0],
                    recording.curves,
                    recording.watched,
                ),
                step,
                state[0],
                state[0],
                state[2],
            )
        call_void(functions[1], numbers, 1.0, state)
        solver_state[DONE] = step + 1
    return SOLVED


@jit_inline
def record_curve(state, fit, k, base, curve):
    """Set ``base`` to the state at the step's centre and its low parts, and ``curve`` to the
    coefficients of the step's curve."""
    m = state.shape[1]
    for i in range(m):
        base[i], base[m + i] = state[4, i], state[6, i]
        base[2 * m + i], base[3 * m + i] = state[5, i], state[7, i]
    for i in range(curve.shape[0]):
        for l in range(curve.shape[1]):
            total = 0.0
            for j in range(fit.shape[0]):
                total += fit[j, l] * k[i, j]
            curve[i, l] = total


@cache
def compiled_advance_frame():
    """The compiled ``advance_frame``, one kernel for all frames."""
    integer = types.int64
    signature = integer(
        types.int64[::1],
        VECTOR,
        TABLES,
        PLAN,
        integer,
        PROGRESS,
        WORK,
        RECORDING,
    )
    return compiled_for(advance_frame, signature, jit_inline)
