"""Many steps of point masses in a clock: Gauss collocation in tau, dt = g(q) dtau.

With M = G m, T = sum M v^2 / 2, U = sum over pairs M_i M_j / r, S = sum over pairs of
((M_i + M_j) / r^3)^kappa and g = S^(-1 / (2 kappa)), kappa = 1 or 1/2, the equations are those of
K = g (H - E0), H = T - U = G times the energy, at K = 0, in v = p / m:

    q' = g v,   v_i' = g (a_i - (H - E0) d(log g)/dq_i / M_i),   t' = g,
    d(log g)/dq_i = 3 / (2 S) sum_j ((M_i + M_j) / r^3)^kappa (q_i - q_j) / r^2.

Slopes are L = h b times the derivative by tau, stages are q + sum_j mu_ij L_j with mu_ij + mu_ji
= 1 exactly: the rounded method is symplectic. Separations of bodies are that at the step's start,
from q and its low part, and the difference of the stages' shifts. A pass takes g and H - E0 from
the last one, then new velocities, then new places.

d = bodies * dimension rows, one for each coordinate; s stages, then zeros, P in all

masses        pairs (5 n,): M_j, M_i, M_i M_j, its low part and (M_i + M_j)^kappa of each pair of
              bodies; members (n, 2): first rows of both; bodies (2, N): M / 2, and 1 / M or
              0 where the term with H - E0 is left out
tables        mu^T and the extrapolation of slopes to the next step (s, P); h b (1, P); the curve's
              coefficients from slopes (m, s)
state         (4, d)   q, its low part, v, its low part
stages        (2 d, s) the last step's slopes of q and v, if solver_state[0] says so
clock         (4,)     t, its low part, E0, its low part
scratch       rows (8, d, P), before (5, at least d and 4), totals (6, P), changes (4, P), gaps
              (n dimension,)
done          (2,)     <- steps, passes
kept          q, v, t, coefficients and g at the stages after each step, as `Taken` of
              galvi.fast.clock_stepper
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.fast.lanes.clocks.rows import (
    CHANGE,
    LENGTH,
    RATE,
    SIZE,
    attract,
    combine,
    drift,
    kick,
    set_clock,
    sum_of,
)  # fmt: skip
from galvi.fast.lanes.law import curve_of
from galvi.fast.lanes.nbody import copy_rows
from galvi.kernels.compile.array_types import MATRIX, TENSOR3, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit_inline
from galvi.kernels.lie.arithmetic import two_sum
from galvi.kernels.nystrom.advance import HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import (
    DIVERGED,
    FIXED_POINT_PASSES,
    GOING,
    NOT_FINITE,
    SOLVED,
    reset_history,
    verdict,
)  # fmt: skip
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR

FAR = 0.5  # relative change by the first pass from which on an extrapolated guess is no use
MASSES = types.Tuple((FIXED_VECTOR, types.Array(types.int64, 2, "C", readonly=True), FIXED_MATRIX))
SCRATCH = types.Tuple((TENSOR3, MATRIX, MATRIX, MATRIX, VECTOR))
TAKEN = types.Tuple((MATRIX, MATRIX, MATRIX, TENSOR3, MATRIX))


@jit_inline
def clear(rows):
    """rows <- 0."""
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            rows[i, k] = 0.0


@jit_inline
def move(form, masses, mu, state, totals, rows, slopes, changes, kicks):
    """New slopes of places and shifts of all bodies, after new slopes of velocities if wanted."""
    for body in range(masses[2].shape[1]):
        row, half, light = body * len(form[0]), masses[2][0, body], masses[2][1, body]
        if kicks:
            kick(form, totals, rows[3], rows[4], row, light, rows[1], changes)
        drift(form, mu, state[2], state[3], row, half, totals, rows[1], slopes, changes)
        combine(form, mu, rows[0], row, rows[2])


@jit_inline
def iterate(form, masses, tables, state, clock, tolerance, scratch, history, guessed):
    """Passes from the slopes in rows until convergence; returns a code and their number."""
    rows, _, totals, changes, gaps = scratch
    pairs, members, _ = masses
    clear(totals)
    clear(rows[3])
    clear(rows[4])
    move(form, masses, tables[0], state, totals, rows, rows[7], changes, False)
    reset_history(history)
    for passes in range(1, FIXED_POINT_PASSES + 1):
        clear(changes)
        for k in range(members.shape[0]):
            attract(form, rows[2], gaps, pairs, k, members[k, 0], members[k, 1], rows[3], rows[4],
                    totals)  # fmt: skip
        set_clock(form, tables[2], clock[2], clock[3], totals)
        move(form, masses, tables[0], state, totals, rows, rows[0], changes, True)
        change = 0.0
        for part in range(0, 4, 2):
            one = sum_of(form, changes, part + CHANGE) / sum_of(form, changes, part + SIZE)
            change = one if not one <= change else change  # NaN too
        if guessed and passes == 1 and not change < FAR:
            return DIVERGED, passes
        code = verdict(change, tolerance, history)
        if code != GOING:
            return code, passes
    return DIVERGED, FIXED_POINT_PASSES


@jit_inline
def add_slopes(form, rows, totals, state, clock):
    """The state and the time at the step's end; returns whether they are finite."""
    size = 0.0
    for part in range(2):
        for i in range(state.shape[1]):
            moved = state[2 * part + 1, i] + sum_of(form, rows[part], i)
            state[2 * part, i], state[2 * part + 1, i] = two_sum(state[2 * part, i], moved)
            size += abs(state[2 * part, i])
    clock[0], clock[1] = two_sum(clock[0], clock[1] + sum_of(form, totals, LENGTH))
    return size + abs(clock[0]) < np.inf


@jit_inline
def begin(form, members, ahead, state, rows, gaps, guessed):
    """The separations of pairs at a step's start, and slopes extrapolated from the last step's."""
    dimension = len(form[0])
    for k in range(members.shape[0]):
        for x in range(dimension):
            i, j = members[k, 0] + x, members[k, 1] + x
            gaps[k * dimension + x] = (state[0, i] - state[0, j]) + (state[1, i] - state[1, j])
    for part in range(2):
        copy_rows(rows[5 + part], rows[part])
        for row in range(0, state.shape[1] if guessed else 0, dimension):
            combine(form, ahead, rows[5 + part], row, rows[part])


@jit_inline
def advance_clock(form, masses, tables, todo, until, tolerance, state, stages, solver_state, clock,
                  scratch, done, kept):  # fmt: skip
    """Do ``todo`` steps; returns a code. A step that fails, or would pass the time ``until`` unless
    that is NaN, is not done."""
    rows, before, totals, _, gaps = scratch
    d, s = state.shape[1], stages.shape[1]
    for part in range(2):
        copy_rows(rows[part], stages[part * d : (part + 1) * d])
    for step in range(todo):
        guessed, code = solver_state[HOLDS] == LAST_STEP, DIVERGED
        copy_rows(before, state)
        begin(form, masses[1], tables[1], state, rows, gaps, guessed)
        for attempt in range(0 if guessed else 1, 2):
            if attempt == 1:
                clear(rows[0])
                clear(rows[1])
            code, passes = iterate(
                form, masses, tables, state, clock, tolerance, scratch, before[4], attempt == 0
            )
            done[1] += passes
            if code == SOLVED:
                break
        t, low = clock[0], clock[1]
        if code == SOLVED and not add_slopes(form, rows, totals, state, clock):
            code = NOT_FINITE
        passed = (clock[0] - until) * (clock[0] - t) > 0.0
        if code != SOLVED or passed:
            copy_rows(state, before)
            clock[0], clock[1] = t, low
            for part in range(2):
                copy_rows(stages[part * d : (part + 1) * d], rows[5 + part])
            return code
        solver_state[HOLDS], done[0] = LAST_STEP, step + 1
        q, v, times, curves, rates = kept
        for i in range(d):
            q[step, i], v[step, i] = state[0, i], state[2, i]
        times[step, 0], times[step, 1] = clock[0], clock[1]
        for k in range(s):
            rates[step, k] = totals[RATE, k]
        if curves.shape[0] > 0:
            curve_of(tables[3], rows[0], curves[step])
    for part in range(2):
        copy_rows(stages[part * d : (part + 1) * d], rows[part])
    return SOLVED


@cache
def compiled_advance_clock(dimension, halves, lanes):
    """``advance_clock`` compiled or cached for a dimension, 2 kappa and the lanes of a vector."""
    whole, numbers = types.int64, types.int64[::1]
    form = types.Tuple(
        [*(types.UniTuple(whole, n) for n in (dimension, halves, lanes)), whole, whole]
    )
    signature = whole(
        form, MASSES, types.UniTuple(FIXED_MATRIX, 4), whole, types.float64, types.float64, MATRIX,
        MATRIX, numbers, VECTOR, SCRATCH, numbers, TAKEN,
    )  # fmt: skip
    return compiled_for(advance_clock, signature, jit_inline)
