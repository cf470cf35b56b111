"""Many steps of point masses in a clock: Gauss collocation in tau, dt = g(q) dtau.

With M = G m, T = sum M v^2 / 2, U = sum over pairs M_i M_j / r less G times the energy of other
forces, S = sum over pairs of (M_i + M_j) / r^3 and g = S^(-1/2), the equations are those of
K = g (H - E0), H = T - U = G times the energy, at K = 0, in v = p / m:

    q' = g v,   v_i' = g (a_i - (H - E0) d(log g)/dq_i / M_i),   t' = g,
    d(log g)/dq_i = 3 / (2 S) sum_j (M_i + M_j) / r^3 (q_i - q_j) / r^2.

H - E0 is 0 but for rounding and the error of the step, and M_i may be too small to divide it. So
S = S_H(q) + sigma(tau), where sigma, the sum over the pairs that hold a light body, is a given
function of tau (which are light: galvi.run.clocked.in_lanes): a pair turns both of its bodies,
j above runs over the heavy ones alone, or neither. The action is then invariant under motions of
the heavy bodies, whose momenta are exact, and their map is symplectic for given sigma. Turning one
of a pair instead breaks that: momentum is lost, and H - E0 grows with absolute velocities.

Slopes are L = h b times the derivative by tau, stages are q + sum_j mu_ij L_j with mu_ij + mu_ji
= 1 exactly: the rounded method is symplectic. The separation of two bodies is that at the step's
start, from q and its low part, plus the difference of their shifts at the stage. A pass computes g
and H - E0 from the last stages, then new velocities, then new positions.

d = bodies * dimension rows, one for each coordinate; s stages, then zeros, P in all

masses        pairs (6 n,): M_j, M_i, M_i M_j, its low part, M_i + M_j, and the same or 0 where one
              is light, of each pair of bodies, those of one body after another; seconds (n,): the
              first row of the other; starts (N + 1,): where a body's pairs begin; bodies (2, N):
              M / 2, and 1 / M or 0 of a light body; terms, poles: of galvi.kernels.forces.
              celestial, WEIGHT times G; mean (dimension,), the velocity of the centre of mass: H
              and E0 are energies in a frame that moves with it, since total momentum is kept and
              the iteration contracts as the velocities in H are small
tables        mu^T and the extrapolation of slopes to the next step (s, P); h b (1, P); the curve's
              coefficients from slopes (m, s)
state         (4, d)   q, its low part, v, its low part
stages        (2 d, s) the last step's slopes of q and v, if solver_state[HOLDS] is LAST_STEP
clock         (4,)     t, its low part, E0, its low part
scratch       rows (8, d, P): slopes of q and v, shifts, pulls, turns, the last step's slopes of q
              and v, scratch; totals (6, P), changes (4, P), gaps of pairs, then of terms, one for
              each axis, history (4,)
noise         relative change below which changes that do not shrink are round-off; then a last pass
              takes the mean of old and new slopes
counts        (2,)     number of steps, which is set, and of passes, which is added to
recording     q, v, t, coefficients and g at the stages after each step, see
              galvi.run.clocked.motion
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, TENSOR3, VECTOR, compiled_for, jit_inline
from galvi.kernels.forces.celestial import SOURCE, TARGET
from galvi.kernels.lie.arithmetic import two_sum
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.advance import HOLDS, LAST_STEP
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR
from galvi.lanes.celestial import add_poles, add_powers
from galvi.lanes.clocks import rows as lanes
from galvi.lanes.loops import curve_of
from galvi.lanes.nbody import FIXED_NUMBERS, copy_rows

# Relative change of the first pass from which on an extrapolated guess is discarded.
BAD_GUESS_CHANGE = 0.5
MASSES = types.Tuple(
    (
        FIXED_VECTOR,
        FIXED_NUMBERS,
        FIXED_NUMBERS,
        FIXED_MATRIX,
        FIXED_MATRIX,
        types.int64,
        FIXED_VECTOR,
    )
)
SCRATCH = types.Tuple((TENSOR3, MATRIX, MATRIX, VECTOR, VECTOR))
RECORDS = types.Tuple((MATRIX, MATRIX, MATRIX, TENSOR3, MATRIX))


@jit_inline
def clear(rows):
    """rows <- 0."""
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            rows[i, k] = 0.0


@jit_inline
def start_step(form, masses, tables, state, scratch, has_guess):
    """Set the separations, slopes and shifts at the start of a step; slopes are extrapolated if
    ``has_guess``, else 0."""
    dimension, (rows, totals, changes, gaps, _) = len(form[0]), scratch
    terms, pairs = masses[4], masses[1].size
    for k in range(terms.shape[0]):
        for x in range(dimension):
            i, j = int(terms[k, SOURCE]) * dimension + x, int(terms[k, TARGET]) * dimension + x
            gap = (state[0, j] - state[0, i]) + (state[1, j] - state[1, i])
            gaps[(pairs + k) * dimension + x] = gap
    for body in range(masses[3].shape[1]):
        for k in range(masses[2][body], masses[2][body + 1]):
            for x in range(dimension):
                i, j = body * dimension + x, masses[1][k] + x
                gaps[k * dimension + x] = (state[0, i] - state[0, j]) + (state[1, i] - state[1, j])
    for part in range(2):
        if not has_guess:
            clear(rows[part])
        for row in range(0, state.shape[1] if has_guess else 0, dimension):
            lanes.combine(form, tables[1], rows[5 + part], row, rows[part])
    clear(totals)
    update_positions(form, masses, tables[0], state, totals, rows, rows[7], 1.0, changes)


@jit_inline
def update_positions(form, masses, mu, state, totals, rows, slopes, share, changes):
    """Set ``slopes`` to new slopes of the positions, from velocities, and the shifts from
    rows[0]."""
    dimension, bodies = len(form[0]), masses[3]
    for body in range(bodies.shape[1]):
        lanes.drift(form, mu, state[2], state[3], masses[6], body * dimension, bodies[0, body],
                    totals, rows[1], slopes, share, changes)  # fmt: skip
    for body in range(bodies.shape[1]):
        lanes.combine(form, mu, rows[0], body * dimension, rows[2])


@jit_inline
def iterate(form, masses, tables, state, clock, tolerance, noise, scratch, has_guess):
    """Iterate the slopes of a step to convergence; returns a code and the number of passes."""
    rows, totals, changes, gaps, history = scratch
    pairs, seconds, starts, bodies, terms, poles, _ = masses
    dimension, share = len(form[0]), 1.0
    first = seconds.size * dimension
    start_step(form, masses, tables, state, scratch, has_guess)
    solve.reset_history(history)
    for passes in range(1, solve.FIXED_POINT_PASSES + 1):
        for body in range(bodies.shape[1]):
            lanes.attract(form, rows[2], gaps, pairs, seconds, body * dimension, starts[body],
                          starts[body + 1], rows[3], rows[4], totals)  # fmt: skip
        if terms.shape[0] > 0:
            add_poles(form, rows[2], rows[3], terms, 0, poles, gaps, first, totals)
            add_powers(form, rows[2], rows[3], terms, poles, terms.shape[0], gaps, first, totals)
        lanes.set_clock(form, tables[2], clock[2], clock[3], totals, changes)
        for body in range(bodies.shape[1]):
            lanes.kick(
                form,
                totals,
                rows[3],
                rows[4],
                body * dimension,
                bodies[1, body],
                rows[1],
                share,
                changes,
            )
        update_positions(form, masses, tables[0], state, totals, rows, rows[0], share, changes)
        change = 0.0
        for part in range(0, 4, 2):
            relative = lanes.sum_of(form, changes, part) / lanes.sum_of(form, changes, part + 1)
            change = relative if not relative <= change else change  # NaN too
        code = solve.decide_inline(change, tolerance, history)
        if has_guess and passes == 1 and not change < BAD_GUESS_CHANGE:
            return solve.DIVERGED, passes
        if share < 1.0 and change < np.inf:
            return solve.SOLVED, passes
        if code != solve.GOING:
            return code, passes
        if history[3] > 0.0 and change < noise:
            share = 0.5
    return solve.DIVERGED, solve.FIXED_POINT_PASSES


@jit_inline
def advance_clock(form, masses, tables, todo, end_time, tolerance, noise, state, stages,
                  solver_state, clock, scratch, counts, recording):  # fmt: skip
    """Do up to ``todo`` steps; returns a code.

    A step that fails, or would pass ``end_time`` (NaN for none), ends the run and leaves the state
    unchanged.
    """
    rows, totals, d, code = scratch[0], scratch[1], state.shape[1], solve.SOLVED
    q, v, times, curves, rates = recording
    for part in range(2):
        copy_rows(rows[part], stages[part * d : (part + 1) * d])
    for step in range(todo):
        code, has_guess = solve.DIVERGED, solver_state[HOLDS] == LAST_STEP
        for part in range(2):
            copy_rows(rows[5 + part], rows[part])
        for attempt in range(0 if has_guess else 1, 2):
            if code != solve.SOLVED:
                code, passes = iterate(
                    form, masses, tables, state, clock, tolerance, noise, scratch, attempt == 0
                )
                counts[1] += passes
        t, low = two_sum(clock[0], clock[1] + lanes.sum_of(form, totals, lanes.LENGTH))
        if code == solve.SOLVED and not abs(t) < np.inf:
            code = solve.NOT_FINITE
        if code != solve.SOLVED or (t - end_time) * (t - clock[0]) > 0.0:
            for part in range(2):
                copy_rows(rows[part], rows[5 + part])
            break
        clock[0], clock[1], times[step, 0], times[step, 1] = t, low, t, low
        solver_state[HOLDS], counts[0] = LAST_STEP, step + 1
        for part in range(2):
            for i in range(d):
                low_sum = state[2 * part + 1, i] + lanes.sum_of(form, rows[part], i)
                state[2 * part, i], state[2 * part + 1, i] = two_sum(state[2 * part, i], low_sum)
        for i in range(d):
            q[step, i], v[step, i] = state[0, i], state[2, i]
        for k in range(stages.shape[1]):
            rates[step, k] = totals[lanes.RATE, k]
        if curves.shape[0] > 0:
            curve_of(tables[3], rows[0], curves[step])
    for part in range(2):
        copy_rows(stages[part * d : (part + 1) * d], rows[part])
    return code


@cache
def compiled_advance_clock(dimension, width):
    """The compiled ``advance_clock`` for a dimension and a number of lanes of a vector."""
    integer, real, numbers = types.int64, types.float64, types.int64[::1]
    form = types.Tuple(
        [*(types.UniTuple(integer, n) for n in (dimension, width)), integer, integer]
    )
    signature = integer(
        form, MASSES, types.UniTuple(FIXED_MATRIX, 4), integer, real, real, real, MATRIX, MATRIX,
        numbers, VECTOR, SCRATCH, numbers, RECORDS,
    )  # fmt: skip
    return compiled_for(advance_clock, signature, jit_inline)
