"""Many steps of point masses under gravity: `galvi.kernels.nystrom.advance` in vector instructions.

Method, prediction, stopping rule and compensated updates are the same, with fewer passes over all
bodies; a step that fixed-point iteration cannot solve is left to the general kernel. One
compilation serves every number of stages s, padded to P, a multiple of LANES.

The first pass over all bodies is followed by PAIR_PASSES over two bodies only, the star and the
planet that moves fastest relative to its distance, which extrapolation predicts by far the worst:
for the Sun and planets, the innermost to 1e-4, the next to 1e-10 (docs/why.md, "Point masses").
These passes only improve the guess. Iterations and force evaluations count the passes over all
bodies; the PAIR_PASSES + 1 evaluations of the single pair, at s stages each, are counted as PAIRS.

d = bodies * dimension rows, one for each coordinate
ahead         ((l + 2) s, P)          h^2 A^T; then for r = 1 .. l the same after extrapolation to
                                      the next step with r Legendre terms; then its low part
series        (s, P)                  Legendre coefficients from stages, transposed
growth        (l,)                    Legendre polynomials at the next step's end
sums          (s, P)                  columns h b, h^2 beta and the low part of each
c             (2, P)                  nodes and their low parts
work          (6, d, P)               stages, last accelerations, h c v, its low part, scratch, new
                                      accelerations
spare         (8, at least d and P)   state before the step (4 rows), sizes, history of the
                                      iteration, scratch, smallest squared distance of two bodies at
                                      each stage
solver_state  (3 + bodies,)           as in the general kernel, then the number of Legendre terms
                                      to extrapolate for each body
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from galvi.kernels.compile.jit import MATRIX, TENSOR3, compiled_for, jit_inline
from galvi.kernels.forces.passages import near_limit, note_passages
from galvi.kernels.lie.arithmetic import generic, two_sum
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.nystrom.step import (
    FIXED_MATRIX,
    FIXED_VECTOR,
    TABLEAU,
    NystromTableau,
    copy_into,
    curve_coefficients,
    terms_to_extrapolate,
)
from galvi.kernels.run_record import PLAN, PROGRESS, RECORDING, Plan, Recording, record
from galvi.lanes import gravity
from galvi.lanes.celestial import add_terms
from galvi.lanes.gravity import LANES, combine, drift, fused

PAIR_PASSES = 3  # 2 and 4 are slower for some problems: docs/why.md


class Bodies(NamedTuple):
    """The bodies, and the terms of other forces than their attraction.

    Attributes
    ----------
    masses : array, shape (bodies,)
        G m
    heavy, light
        indices of the bodies with a mass, and of the massless ones
    pulls, poles
        terms of galvi.kernels.forces.celestial, and the number of pole terms, which come first
    star
        index of the heaviest body
    """

    masses: Any
    heavy: Any
    light: Any
    pulls: Any
    poles: Any
    star: Any


class Tables(NamedTuple):
    """The tables of a method, see the docstring of the module."""

    ahead: Any
    series: Any
    growth: Any
    sums: Any
    c: Any


class Step(NamedTuple):
    """The arrays of the current step.

    Attributes
    ----------
    state : array, shape (4, d)
        at its start
    Q, a : array, shape (d, P)
        stages and their last accelerations
    base, low : array, shape (d, P)
        h c v, and the sum of its low part and that of q
    scratch : array, shape (d, P)
    sizes : array, shape (bodies,)
        inverse sizes of the coordinates of each body, at the start and after a step without forces
    history : array, shape (4,)
        see galvi.kernels.nystrom.solve
    nearest : array, shape (P,)
        smallest squared distance of two bodies at each stage; 0 if not measured
    """

    state: Any
    Q: Any
    a: Any
    base: Any
    low: Any
    scratch: Any
    sizes: Any
    history: Any
    nearest: Any


@jit_inline
def pull_all(axes, bodies, Q, a):
    """a <- accelerations at stages Q; the attractions of the last pairs are added first."""
    masses, heavy, light = bodies.masses, bodies.heavy, bodies.light
    for k in range(heavy.size - 1, -1, -1):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.attract(axes, Q, a, masses, heavy, k, Q.shape[1], chunk)
    for k in range(light.size):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.follow(axes, Q, a, masses, heavy, light[k], Q.shape[1], chunk)


@jit_inline
def pull_and_measure(axes, bodies, Q, a, nearest):
    """`pull_all`, and nearest (P,) <- the smallest squared distance of two bodies at each stage."""
    masses, heavy, light = bodies.masses, bodies.heavy, bodies.light
    for k in range(Q.shape[1]):
        nearest[k] = math.inf
    for k in range(heavy.size - 1, -1, -1):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.attract_and_measure(axes, Q, a, masses, heavy, k, Q.shape[1], chunk, nearest)
    for k in range(light.size):
        for chunk in range(Q.shape[1] // gravity.LANES):
            gravity.follow_and_measure(
                axes, Q, a, masses, heavy, light[k], Q.shape[1], chunk, nearest
            )


@jit_inline
def pull_pair(axes, bodies, planet, sign, Q, initial, a):
    """Set the rows of the star and of a planet in ``a`` to those of ``initial`` plus ``sign`` times
    the attraction between the two."""
    star, masses = bodies.star, bodies.masses
    star_mass, planet_mass = sign * masses[star], sign * masses[planet]
    for chunk in range(Q.shape[1] // gravity.LANES):
        gravity.attract_pair(
            axes, Q, initial, a, star, planet, star_mass, planet_mass, Q.shape[1], chunk
        )


@jit_inline
def move_body(axes, moves, start, s, a, step, change, body):
    """Q <- q + (base + (low + h^2 A a)) for one body.

    Returns the larger of ``change`` and the largest change of Q relative to the body's size.
    """
    for chunk in range(a.shape[1] // gravity.LANES):
        change = gravity.move(
            axes, moves, start, a, step.base, step.low, step.state, step.Q, change,
            step.sizes[body], body, s, chunk,
        )  # fmt: skip
    return change


@jit_inline
def add_low_parts(axes, moves, s, a, low):
    """low += the low part of h^2 A^T times the accelerations at the stages."""
    for body in range(a.shape[0] // len(axes)):
        for chunk in range(a.shape[1] // gravity.LANES):
            gravity.add_combined(
                axes, moves, moves.shape[0] - s, a, low, body, s, a.shape[1], chunk
            )


@jit_inline
def iterate_pair(axes, bodies, planet, moves, s, step):
    """Do PAIR_PASSES passes over the star and one planet; ``step.scratch`` holds their
    accelerations without the attraction between the two.

    Extrapolation predicts the fastest planet worst, and these passes are cheap. They contract like
    the passes over all bodies, which continue from there.
    """
    history, a = step.history, step.a
    last, change = history[0], history[0]
    for _passes in range(PAIR_PASSES):
        last = change
        pull_pair(axes, bodies, planet, 1.0, step.Q, step.scratch, a)
        change = move_body(axes, moves, 0, s, a, step, 0.0, bodies.star)
        change = move_body(axes, moves, 0, s, a, step, change, planet)
    solve.reset_history(history)
    if change > 0.0:
        history[0], history[1] = change, change / last


@jit_inline
def iterate(axes, bodies, fastest_planet, moves, s, step, tolerance, counts):
    """Iterate from stages Q until convergence; returns a code.

    Then ``step.a`` holds the last accelerations, and ``step.nearest`` the distances of the second
    pass, which is accurate enough for them; ``step.nearest[0]`` is 0 if there was none.
    """
    Q, a, history, has_low_parts = step.Q, step.a, step.history, False
    step.nearest[0] = 0.0
    solve.reset_history(history)
    for passes in range(solve.FIXED_POINT_PASSES):
        if passes == 1:
            pull_and_measure(axes, bodies, Q, a, step.nearest)
        else:
            pull_all(axes, bodies, Q, a)
        add_terms(axes, bodies.pulls, bodies.poles, s, Q, a)
        with_pair = passes == 0 and bodies.masses.size > 2
        if with_pair:
            pull_pair(axes, bodies, fastest_planet, -1.0, Q, a, step.scratch)
            counts[solve.PAIRS] += (PAIR_PASSES + 1) * s
        change = 0.0
        for body in range(bodies.masses.size):
            change = move_body(axes, moves, 0, s, a, step, change, body)
        counts[solve.ITERATIONS] += 1
        counts[solve.FORCES] += s
        code = solve.decide_inline(change, tolerance, history)
        if not has_low_parts and solve.gives_low_parts_inline(change, tolerance):
            has_low_parts = True
            add_low_parts(axes, moves, s, a, step.low)
        elif code != solve.GOING:
            return code
        if with_pair:
            iterate_pair(axes, bodies, fastest_planet, moves, s, step)
    return solve.DIVERGED


GRAVITY_TABLES = types.Tuple((FIXED_MATRIX, FIXED_MATRIX, FIXED_VECTOR, FIXED_MATRIX, FIXED_MATRIX))
FIXED_NUMBERS = types.Array(types.int64, 1, "C", readonly=True)
STEPS_BETWEEN_CHOICES = 16  # steps from one choice of the terms to extrapolate to the next


@jit_inline
def choose_terms(axes, tables, a, out, terms, sizes):
    """terms <- the number of Legendre terms of each body's accelerations to extrapolate.

    ``out`` (d, P) and ``sizes`` (s,) are scratch.
    """
    series, growth, dimension = tables.series, tables.growth, len(axes)
    s, padded = series.shape
    for body in range(terms.size):
        for chunk in range(padded // LANES):
            combine(axes, series, 0, a, out, body, s, padded, chunk)
        for l in range(s):
            sizes[l] = 0.0
            for x in range(dimension):
                sizes[l] = max(sizes[l], abs(out[body * dimension + x, l]))
        terms[body] = terms_to_extrapolate(sizes, growth)


@jit_inline
def start_step(axes, bodies, tables, h, terms, a, step):
    """Set ``base``, ``low``, ``sizes`` and the initial stages Q of a step.

    ``a`` holds accelerations at the stages: of the last step, to extrapolate by terms[i] terms for
    body i, or of this step if terms[i] is 0. Returns the body other than the star with the largest
    displacement relative to its size.
    """
    state, sizes, c, star = step.state, step.sizes, tables.c, bodies.star
    dimension, padded, s = len(axes), c.shape[1], tables.series.shape[0]
    largest, largest_ratio, fastest_planet = 0.0, 0.0, 1 if star == 0 else 0
    for body in range(sizes.size):
        size, displacement_size = 0.0, 0.0
        for x in range(dimension):
            i = body * dimension + x
            displacement = h * state[2, i]
            displacement_low = fused(h, state[2, i], -displacement) + h * state[3, i]
            for chunk in range(padded // LANES):
                drift(
                    c,
                    step.base,
                    step.low,
                    i,
                    displacement,
                    displacement_low,
                    state[1, i],
                    padded,
                    chunk,
                )
            displacement_size = max(displacement_size, abs(displacement))
            size = max(size, abs(state[0, i]), abs(state[0, i] + displacement))
        sizes[body] = size
        largest = max(largest, size)
        if body != star and displacement_size > largest_ratio * size:
            fastest_planet, largest_ratio = body, displacement_size / size
    for body in range(sizes.size):
        size = sizes[body] if sizes[body] > 0.0 else largest
        sizes[body] = 1.0 / size if size > 0.0 else 1.0
        move_body(axes, tables.ahead, terms[body] * s, s, a, step, 0.0, body)
    return fastest_planet


@jit_inline
def passage_limit(nearest, fast, slow):
    """The squared distance within which passages of the step are noted; 0 if there are none.

    There are some if the smallest squared distance is below ``fast`` or below slow^(2/3). The limit
    is ``fast``, or 1.01 times the smallest squared distance if that is larger.
    """
    closest = math.inf
    for k in range(nearest.size):
        closest = min(closest, nearest[k])
    if closest < fast or closest * closest * closest < slow * slow:
        return max(fast, 1.01 * closest)
    return 0.0


@jit_inline
def finish(axes, sums, h, a, state, out):
    """Move the state to the end of the step, as galvi.kernels.nystrom.step.complete_step.

    ``out`` (d, P) is scratch. Returns whether the state is finite.
    """
    absolute_sum = 0.0
    for body in range(a.shape[0] // len(axes)):
        combine(axes, sums, 0, a, out, body, sums.shape[0], a.shape[1], 0)
    for i in range(state.shape[1]):
        q, q_low, v, v_low = state[0, i], state[1, i], state[2, i], state[3, i]
        displacement = h * v
        remainder = fused(h, v, -displacement) + (h * v_low + out[i, 3])
        state[0, i], state[1, i] = move_compensated(q, q_low, displacement, out[i, 1], remainder)
        kicked, kick_low = two_sum(v, out[i, 0])
        state[2, i], state[3, i] = two_sum(kicked, kick_low + (v_low + out[i, 2]))
        absolute_sum += abs(state[0, i]) + abs(state[2, i])
    return absolute_sum < np.inf


@generic
def move_compensated(x, low, displacement, increment, remainder):
    """x + low + displacement + increment + remainder as a rounded sum and its low part; ``low`` and
    ``remainder`` are small."""
    end, error = two_sum(x, displacement)
    end, second_error = two_sum(end, increment)
    return two_sum(end, error + (second_error + (low + remainder)))


@jit_inline
def advance(axes, masses, heavy, light, pulls, poles, tableau, tables, plan, todo, progress, work,
            spare, recording):  # fmt: skip
    """Do ``todo`` more steps of a run; returns a code of galvi.kernels.nystrom.solve.

    A step that fails leaves the state as it was before this step.
    """
    tableau, plan, recording, tables = (
        NystromTableau(*tableau),
        Plan(*plan),
        Recording(*recording),
        Tables(*tables),
    )
    state, stages, solver_state, counts, passage = progress
    h, n = plan.step, tableau.velocity_coefficients.size
    s, d = tables.series.shape[0], state.shape[1]
    Q, a, scratch, new_a = work[0], work[1], work[4], work[5]
    before, terms, nearest = spare[:4, :d], solver_state[3:], spare[7, : Q.shape[1]]
    star = 0
    for body in range(masses.size):
        if masses[body] > masses[star]:
            star = body
    bodies = Bodies(masses, heavy, light, pulls, poles, star)
    copy_rows(a, stages)
    for step in range(solver_state[DONE], solver_state[DONE] + todo):
        copy_into(before, state)
        if solver_state[HOLDS] != LAST_STEP:
            terms[:] = 0
        elif (plan.first + step) % STEPS_BETWEEN_CHOICES == 0 or terms[0] == 0:
            choose_terms(axes, tables, a, scratch, terms, spare[6, :s])
        current = Step(
            state,
            Q,
            new_a,
            work[2],
            work[3],
            scratch,
            spare[4, : masses.size],
            spare[5, :4],
            nearest,
        )
        fastest_planet = start_step(axes, bodies, tables, h, terms, a, current)
        code = iterate(
            axes, bodies, fastest_planet, tables.ahead, s, current, plan.tolerance, counts
        )
        if code == SOLVED and not finish(axes, tables.sums, h, new_a, state, scratch):
            code = NOT_FINITE
        if code != SOLVED:
            copy_into(state, before)
            copy_rows(stages, a)
            return code
        a, new_a = new_a, a
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, step + 1
        record(plan, recording, step, before[0], state[0], state[2])
        limit = passage_limit(nearest, *near_limit(passage, before[2], h, n))
        if limit > 0.0:
            note_passages(
                passage, Q, tableau.c, before[0], state[0], h, n, limit, plan.first + step + 1
            )
        if recording.bases.shape[0] > 0:
            copy_rows(stages, a)
            curve_coefficients(tableau, h, before, stages, recording.curves[step])
    copy_rows(stages, a)
    return SOLVED


@jit_inline
def copy_rows(target, source):
    """Copy the rows of ``target`` from ``source``, as many columns as both arrays have."""
    for i in range(target.shape[0]):
        for k in range(min(target.shape[1], source.shape[1])):
            target[i, k] = source[i, k]


@cache
def compiled_advance(dimension):
    """The compiled ``advance`` for bodies in the plane or in space."""
    integer = types.int64
    signature = integer(
        types.UniTuple(integer, dimension), FIXED_VECTOR, *(FIXED_NUMBERS,) * 2, FIXED_MATRIX,
        integer, TABLEAU, GRAVITY_TABLES, PLAN, integer, PROGRESS, TENSOR3, MATRIX, RECORDING,
    )  # fmt: skip
    return compiled_for(advance, signature, jit_inline)
