"""Positions on the curves of many steps in a frame, and states after a part of such a step."""

from __future__ import annotations

import math
from functools import cache

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.internals import cgutils
from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline
from galvi.kernels.nystrom.solve import NOT_FINITE
from galvi.lanes.frames import universal
from galvi.lanes.frames.collocation import STAGES, TABLES, leave, solve_step
from galvi.lanes.frames.kepler_motion import MAX_CORRECTIONS, NAN, dot
from galvi.lanes.frames.rows import (
    ECCENTRICITY,
    OFFSET,
    PHASE,
    POSITION,
    REVOLUTIONS,
    SLOPE,
    WEIGHT,
    add_rows,
    place_nodes,
)
from galvi.lanes.functions import square_root
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, Lanes

DRIFT_INDEX = 1  # in the addresses of a frame's functions
STEP_LENGTH = 0  # index of h in the numbers
# Positions in one vector: it fills two registers, whose divisions overlap.
POINTS_AT_ONCE = 2 * LANES
# Largest ratio to X of a correction that is the last one; its error is of third order.
LAST_CUBIC_CORRECTION = 1e-4
LEAST_NODE_STRETCH = 1e-8  # below this stretch, nodes are not moved
BASES = types.Array(types.float64, 3, "C", readonly=True)
POSITIONS = types.Array(types.float64, 3, "C")


@jit_inline
def enter_base(base, state):
    """Set rows 4 to 7 of the state (8, m) from the base (4, m) of a curve."""
    for i in range(base.shape[1]):
        state[4, i], state[6, i] = base[0, i], base[1, i]
        state[5, i], state[7, i] = base[2, i], base[3, i]


@intrinsic
def move_orbits(typingctx, axes, mass, chunk, rows):
    """Move positions along Kepler's orbits, in a vector of POINTS_AT_ONCE columns of ``rows``.

    The first D rows hold positions q, which are replaced by those after the times t; the next D
    rows hold velocities v, and the row after these t. NaN where the iteration did not converge.

    Parameters
    ----------
    axes
        a tuple whose length is the dimension D
    mass
        G times the sum of both masses
    """
    D = axes.count

    def generate(context, builder, signature, values):
        matrix = context.make_array(signature.args[3])(context, builder, values[3])
        width = builder.extract_value(matrix.shape, 1)
        lanes, row = Lanes(context, builder, width, values[2], POINTS_AT_ONCE), width.type
        *vectors, t = (Lane(builder, lanes.load(matrix.data, row(r))) for r in range(2 * D + 1))
        q, v, mu = vectors[:D], vectors[D:], Lane(builder, lanes.spread(values[1]))
        r0, eta = dot(q, q).call("sqrt"), dot(q, v)
        beta = 2.0 * mu / r0 - dot(v, v)
        zeta = mu - beta * r0
        mean = t * beta / mu
        X, change = lanes.variable(mean.value), lanes.variable(lanes.zero)
        functions = [lanes.variable(lanes.zero) for _ in range(5)]
        with cgutils.for_range(builder, ir.Constant(ir.IntType(64), MAX_CORRECTIONS)) as loop:
            x = Lane(builder, builder.load(X))
            G = universal.universal(beta, x, universal.SERIES_TERMS)
            step = universal.far_correction(
                beta, r0, eta, zeta, x, G, t, lambda a, b: a / b, square_root
            )
            builder.store(step.value, change)
            for pointer, value in zip(functions, G, strict=True):
                builder.store(value.value, pointer)
            with builder.if_then((abs(step) <= LAST_CUBIC_CORRECTION * abs(x)).all):
                loop.do_break()
            builder.store((x + step).value, X)
        x, step = (Lane(builder, builder.load(pointer)) for pointer in (X, change))
        G = [Lane(builder, builder.load(pointer)) for pointer in functions]
        _, G2, G3, _, _ = universal.shifted(beta, G, step)
        solved = abs(step) <= LAST_CUBIC_CORRECTION * abs(x)
        f, g = 1.0 - mu * G2 / r0, t - mu * G3
        for k in range(D):
            position = (f * q[k] + g * v[k]).where(solved, NAN)
            lanes.store(position.value, matrix.data, row(k))
        return context.get_dummy_value()

    return types.void(axes, mass, chunk, rows), generate


@jit_inline
def places_in_steps(axes, masses, bases, parts, psi, since, rows, positions):
    """positions (k, D n + D, P) <- those of n pairs, by coordinates, and of the barycentre in k
    steps.

    Parameters
    ----------
    masses : array, shape (n,)
        G times the masses of the pairs
    bases : array, shape (k, 4, m)
        states at the centres of the steps: positions, velocities and their low parts
    parts : array, shape (k, 2 n D, l)
        coefficients of the curves of w
    psi : array, shape (k, l, P)
        basis functions of these curves at the times
    since : array, shape (k, P)
        times since the centres of the steps
    rows : array, shape (2 D + 1, columns)
        scratch; the number of columns is a multiple of POINTS_AT_ONCE, and at least P
    """
    D, n, count = len(axes), masses.size, since.shape[1]
    for k in range(bases.shape[0]):
        for p in range(n):
            for half in range(2):
                for x in range(D):
                    row, i = half * D + x, x * n + p
                    for j in range(rows.shape[1]):
                        rows[row, j] = bases[k, half, i]
                    for l in range(parts.shape[2]):
                        part = parts[k, half * D * n + i, l]
                        for j in range(count):
                            rows[row, j] += part * psi[k, l, j]
            for j in range(rows.shape[1]):
                rows[2 * D, j] = since[k, j] if j < count else 0.0
            for chunk in range(rows.shape[1] // POINTS_AT_ONCE):
                move_orbits(axes, masses[p], chunk, rows)
            for x in range(D):
                for j in range(count):
                    positions[k, x * n + p, j] = rows[x, j]
        for i in range(D * n, D * n + D):
            for j in range(count):
                positions[k, i, j] = bases[k, 0, i] + since[k, j] * bases[k, 1, i]


@cache
def compiled_places_in_steps(dimension):
    """The compiled ``places_in_steps`` for a dimension."""
    axes = types.UniTuple(types.int64, dimension)
    signature = types.void(axes, VECTOR, BASES, BASES, POSITIONS, MATRIX, MATRIX, POSITIONS)
    return compiled_for(places_in_steps, signature, jit_inline)


@jit_inline
def stretch_nodes(c, stretch, nodes):
    """Set the positions in [-1, 1] and the slopes of the nodes c, as
    galvi.run.in_frame.kernel.stretched."""
    for j in range(c.size):
        y = 2.0 * c[j] - 1.0
        nodes[POSITION, j], nodes[SLOPE, j] = y, 1.0
        if stretch >= LEAST_NODE_STRETCH:
            end_angle = math.asin(stretch)
            nodes[POSITION, j] = math.asin(stretch * y) / end_angle
            nodes[SLOPE, j] = stretch / end_angle / math.sqrt(1.0 - (stretch * y) ** 2)


@jit_inline
def set_offsets(clock, length, b, c, nodes):
    """Set the times since the step's centre and the weights of the nodes c of a step of
    ``length``."""
    if clock[ECCENTRICITY] >= 0.0:
        place_nodes(clock, 0.0, length, b, nodes)
    else:
        for j in range(nodes.shape[1]):
            nodes[OFFSET, j], nodes[WEIGHT, j] = (c[j] - 0.5) * length, length


@jit_inline
def states_in_steps(functions, numbers, tables, stretch, steps, scratch, outputs):
    """Compute states within steps, each by a shortened step from the start of its step.

    Parameters
    ----------
    steps
        bases (k, 4, m) as for ``places_in_steps``; times (k,) since the starts of the steps; and
        the mean anomalies of the reference orbit over 2 pi at these starts (k,)
    scratch
        stages, coarse stages, work and spare of galvi.lanes.frames.collocation, and a state
    outputs
        q and v (2, k, d), codes (k,) and counts, which are set
    """
    _, b, c, _, clock, _, _, coarse = tables
    bases, lengths, phases = steps
    states, codes, counts = outputs
    stages, coarse_stages, work, spare, state = scratch
    n, d, full_length, revolutions = (
        stages[0].shape[0] // 2,
        states.shape[2],
        numbers[STEP_LENGTH],
        clock[REVOLUTIONS],
    )
    for k in range(bases.shape[0]):
        enter_base(bases[k], state)
        call_void(functions[DRIFT_INDEX], numbers, -0.5, state)
        length_ratio = lengths[k] / full_length
        numbers[STEP_LENGTH], clock[REVOLUTIONS], clock[PHASE] = (
            lengths[k],
            revolutions * length_ratio,
            phases[k],
        )
        call_void(functions[DRIFT_INDEX], numbers, 0.5, state)
        if coarse[0].shape[0] > 0:
            stretch_nodes(coarse[2], stretch * length_ratio, coarse_stages[2])
            set_offsets(clock, lengths[k], coarse[1], coarse[2], coarse_stages[2])
        stretch_nodes(c, stretch * length_ratio, stages[2])
        set_offsets(clock, lengths[k], b, c, stages[2])
        codes[k] = solve_step(
            functions, numbers, tables, state, counts, stages, coarse_stages, work
        )
        add_rows(b, stages[1], state[4], state[5], 0, n)
        add_rows(b, stages[1], state[6], state[7], n, n)
        if not leave(functions, numbers, state, spare, d):
            codes[k] = NOT_FINITE
        for i in range(d):
            states[0, k, i], states[1, k, i] = state[0, i], state[2, i]
        numbers[STEP_LENGTH], clock[REVOLUTIONS] = full_length, revolutions


@cache
def compiled_states_in_steps():
    """The compiled ``states_in_steps``."""
    steps = types.Tuple((BASES, VECTOR, VECTOR))
    scratch = types.Tuple((STAGES, STAGES, MATRIX, MATRIX, MATRIX))
    outputs = types.Tuple((POSITIONS, types.int64[::1], types.int64[::1]))
    signature = types.void(types.int64[::1], VECTOR, TABLES, types.float64, steps, scratch, outputs)
    return compiled_for(states_in_steps, signature, jit_inline)
