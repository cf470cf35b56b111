"""Many steps of Gauss collocation in a frame that moves with an integrable flow.

The system's Hamiltonian is A + B(q), where the flow phi of A is known. In the frame centred at the
middle of a step, z = phi_t(w) with t the time since then, and w' = D phi_-t(z) (0, -dB/dq): what is
left is slow and small. A step solves W_j = w + sum_l A_jl k_l, k_j = weight_j w'(W_j, t_j), sets
w <- w + sum_j b_j k_j and moves on to the next centre, w <- phi_h(w).

n rows each for places and velocities in the frame, d coordinates of the problem, s stages padded to
P, a multiple of LANES

functions  (3,)    addresses of the frame's RATES, DRIFT and LEAVE
numbers    (c,)    their constants, which include h
state      (8, m)  q, its low part, v, its low part at the end of the last step, which are computed
                   where they are kept; then the same in the frame: at the problem's start, or,
                   after a step, at the next one's centre; m >= d and n
tables     A^T (s, P); b (P,), 0 after the last stage; c (P,); coefficients of a curve from slopes,
           transposed (s, m); clock (3,), see `place_nodes`, with eccentricity -1 for equal weights;
           1 / sizes of the rows (2 n,); checks (4,); coarse
checks     (4,)    passes of a step; the relative change of W before the last of them above which
                   further ones are made; what these may leave; and the last change measured
coarse     for the first pass, whose states are all the same: at fewer nodes, their matrix to the
           stages (s', P), weights (P',) and places (P',), and the values (s', P) of their
           polynomials at the stages, by which guesses are interpolated; s' is 0 where the first
           pass is done at all nodes
nodes      (5, P)  times, times since the step's centre, weights dt/dc, then places of the nodes in
                   [-1, 1] and their slopes, which are given
spare      (8, m)
ways       (m + 1, s + 2) places at a step's start, stages and end; in the last row the shares of
           it there, the last of which is given
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
# is scratch for eight stages, guess (.., P) is kept from pass to pass; the first pass is 0
RATES = types.void(VECTOR, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, REAL)
# (numbers, share, state): rows 4 to 7 of the state move by a share of a step, at most 1
DRIFT = types.void(VECTOR, REAL, MATRIX)
# (numbers, state): rows 0 to 3 from rows 4 to 7
LEAVE = types.void(VECTOR, MATRIX)
COARSE = types.Tuple((MATRIX, VECTOR, VECTOR, MATRIX))
TABLES = types.Tuple((MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, VECTOR, VECTOR, COARSE))
STAGES = types.UniTuple(MATRIX, 4)
WORK = types.Tuple((STAGES, STAGES, MATRIX, MATRIX, MATRIX))
MAX_PASSES = 60
PASSES, ALARM, LEFT, CHANGE = range(4)
FURTHER = 2  # passes more than usual, after which a step is given up
INFINITE = 1e300
ROUNDING_CHANGE = 2.0**-48  # relative change of W that rounding can make
CONTRACTS = 0.5  # largest ratio of two changes for which further passes are worth their time


@jit_inline
def solve_step(functions, numbers, tables, state, counts, stages, coarse_stages, work):
    """k at the solution of a step's equations; returns a code.

    A fixed number of passes, unless the last change is larger than it was at the start of the run;
    then a few more, until they leave no more than ``checks`` allow: changes shrink by a ratio r,
    and the slopes at the last W are r^2 of its change off. There is no limit for an alarm below 0.
    """
    matrix, b, c, fit, clock, sizes, checks, coarse = tables
    W, k, nodes, guess = stages
    s, last, change, first = matrix.shape[0], 0.0, 0.0, 1
    wanted = int(checks[PASSES])
    spread_rows(state[4], state[6], W)
    if coarse[0].shape[0] > 0:
        few_W, few_k, few_nodes, few_guess = coarse_stages
        spread_rows(state[4], state[6], few_W)
        call_void(functions[0], numbers, few_nodes, few_W, work, few_guess, few_k, 0.0)
        interpolate_rows(coarse[3], few_guess, guess)
        counts[ITERATIONS] += 1
        counts[FORCES] += coarse[0].shape[0]
        change = place_rows(coarse[0], few_k, state[4], state[6], W, sizes, wanted <= 2)
        first = 2
    for passes in range(first, MAX_PASSES + 1):
        call_void(functions[0], numbers, nodes, W, work, guess, k, float(passes - 1))
        counts[ITERATIONS] += 1
        counts[FORCES] += s
        checks[CHANGE] = change
        if passes == wanted and change <= checks[ALARM]:
            return SOLVED
        if passes > wanted:
            if change <= ROUNDING_CHANGE or change * change * change <= checks[LEFT] * last * last:
                return SOLVED
            if not change < INFINITE:
                return NOT_FINITE
            if passes >= wanted + FURTHER and checks[ALARM] >= 0.0:
                return DIVERGED
            if passes > 4 and change > CONTRACTS * last:
                return DIVERGED
        last = change
        change = place_rows(matrix, k, state[4], state[6], W, sizes, passes >= wanted - 1)
    return DIVERGED


@jit_inline
def see(functions, numbers, share, state, spare):
    """q and v, in rows 0 and 2 of ``spare``, at a share of a step after w in rows 4 to 7 of the
    state."""
    for row in range(4, 8):
        for i in range(state.shape[1]):
            spare[row, i] = state[row, i]
    if share != 0.0:
        call_void(functions[1], numbers, share, spare)
    call_void(functions[2], numbers, spare)


@jit_inline
def place_way(functions, numbers, h, state, spare, W, nodes, path):
    """q at the start of a step and at its stages W, in the columns of ``path``, and the shares of
    the step there in its last row."""
    n = W.shape[0] // 2
    for look in range(path.shape[1]):
        share = nodes[OFFSET, look - 1] / h if look > 0 else -0.5
        see(functions, numbers, 0.0, state, spare)
        for i in range(n):
            if look > 0:
                spare[4, i], spare[5, i] = W[i, look - 1], 0.0
                spare[6, i], spare[7, i] = W[n + i, look - 1], 0.0
        call_void(functions[1], numbers, share, spare)
        call_void(functions[2], numbers, spare)
        for i in range(path.shape[0] - 1):
            path[i, look] = spare[0, i]
        path[path.shape[0] - 1, look] = share + 0.5


@jit_inline
def leave(functions, numbers, state, spare, d):
    """Rows 0 to 3 of the state at the step's end from w at its centre, in rows 4 to 7.

    Returns whether they are finite; else they stay as they are.
    """
    see(functions, numbers, 0.5, state, spare)
    total = 0.0
    for i in range(d):
        total += abs(spare[0, i]) + abs(spare[2, i])
    if not total < INFINITE:
        return False
    for row in range(4):
        for i in range(d):
            state[row, i] = spare[row, i]
    return True


@jit_inline
def set_nodes(plan, clock, number, b, c, nodes):
    """The times and weights of the nodes c of a step."""
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
            keep_curve(state, fit, k, recording.bases[step], recording.curves[step])
        passing = False
        if passage.size > 0:
            see(functions, numbers, 0.0, state, spare)
            passing = may_pass(passage, spare[0], spare[2], plan.step, matrix.shape[0])
        if passing:
            place_way(functions, numbers, plan.step, state, spare, W, nodes, path[:, :-1])
        add_rows(b, k, state[4], state[5], 0, n)
        add_rows(b, k, state[6], state[7], n, n)
        if passing:
            see(functions, numbers, 0.5, state, spare)
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
def keep_curve(state, fit, k, base, curve):
    """Record the state at the step's centre, its low parts, and the coefficients of its curve."""
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
    """``advance_frame`` compiled or cached, one kernel for all frames."""
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
