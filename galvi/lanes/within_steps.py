"""Places on the curves of many steps in a frame, and states after a part of such a step."""

from __future__ import annotations

import math
from functools import cache

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.internals import cgutils
from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline
from galvi.kernels.nystrom.solve import SOLVED
from galvi.lanes.frames import universal
from galvi.lanes.frames.collocation import STAGES, TABLES, leave, solve_step
from galvi.lanes.frames.kepler_motion import MAX_CORRECTIONS, NAN, dot
from galvi.lanes.frames.rows import (
    ECCENTRICITY,
    OFFSET,
    PACE,
    PHASE,
    PLACE,
    TURNS,
    WEIGHT,
    add_rows,
    place_nodes,
)
from galvi.lanes.functions import square_root
from galvi.lanes.values import Lane
from galvi.lanes.vectors import LANES, Lanes

DRIFT = 1  # of the addresses
LENGTH = 0  # of the numbers: that of the step
WIDE = 2 * LANES  # places that are sought at once: two vectors, for which divisions overlap
# Share of X up to which a correction, which converges as a cube, is the last one.
LAST_CUBIC_CORRECTION = 1e-4
LEAST_STRETCH = 1e-8  # stretch up to which nodes stay where they are
BASES = types.Array(types.float64, 3, "C", readonly=True)
PLACES = types.Array(types.float64, 3, "C")


@jit_inline
def enter_base(base, state):
    """Rows 4 to 7 of the state (8, m) from the base (4, m) of a curve."""
    for i in range(base.shape[1]):
        state[4, i], state[6, i] = base[0, i], base[1, i]
        state[5, i], state[7, i] = base[2, i], base[3, i]


@intrinsic
def move_orbits(typingctx, axes, mass, chunk, rows):
    """Places q in a vector of lanes of the first D rows <- those after t on Kepler's orbits.

    The next D rows are velocities v, the one after t; NaN where the iteration did not converge.

    Parameters
    ----------
    axes
        as many entries as there are dimensions D; mass is G times the sum of both
    """
    D = axes.count

    def generate(context, builder, signature, values):
        matrix = context.make_array(signature.args[3])(context, builder, values[3])
        width = builder.extract_value(matrix.shape, 1)
        lanes, row = Lanes(context, builder, width, values[2], WIDE), width.type
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
        _, G2, G3, _, _ = universal.moved(beta, G, step)
        solved = abs(step) <= LAST_CUBIC_CORRECTION * abs(x)
        f, g = 1.0 - mu * G2 / r0, t - mu * G3
        for k in range(D):
            position = (f * q[k] + g * v[k]).where(solved, NAN)
            lanes.store(position.value, matrix.data, row(k))
        return context.get_dummy_value()

    return types.void(axes, mass, chunk, rows), generate


@jit_inline
def places_in_steps(axes, masses, bases, parts, psi, since, rows, places):
    """places (k, D n + D, P) <- those of n pairs, by coordinates, and of the barycentre on k steps.

    Parameters
    ----------
    masses : array, shape (n,)
        of pairs, times G
    bases : array, shape (k, 4, m)
        states at the steps' centres and their low parts
    parts : array, shape (k, 2 n D, l)
        coefficients of the curves of w
    psi : array, shape (k, l, P)
        their basis functions at the places
    since : array, shape (k, P)
        times since the steps' centres
    rows : array, shape (2 D + 1, P or more, a multiple of WIDE)
        scratch
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
            for chunk in range(rows.shape[1] // WIDE):
                move_orbits(axes, masses[p], chunk, rows)
            for x in range(D):
                for j in range(count):
                    places[k, x * n + p, j] = rows[x, j]
        for i in range(D * n, D * n + D):
            for j in range(count):
                places[k, i, j] = bases[k, 0, i] + since[k, j] * bases[k, 1, i]


@cache
def compiled_places_in_steps(dimension):
    """``places_in_steps`` compiled or cached for a dimension."""
    axes = types.UniTuple(types.int64, dimension)
    signature = types.void(axes, VECTOR, BASES, BASES, PLACES, MATRIX, MATRIX, PLACES)
    return compiled_for(places_in_steps, signature, jit_inline)


@jit_inline
def stretch_nodes(c, stretch, nodes):
    """Places in [-1, 1] and slopes of the nodes c, as galvi.run.in_frame.kernel.stretched."""
    for j in range(c.size):
        y = 2.0 * c[j] - 1.0
        nodes[PLACE, j], nodes[PACE, j] = y, 1.0
        if stretch >= LEAST_STRETCH:
            end_angle = math.asin(stretch)
            nodes[PLACE, j] = math.asin(stretch * y) / end_angle
            nodes[PACE, j] = stretch / end_angle / math.sqrt(1.0 - (stretch * y) ** 2)


@jit_inline
def set_offsets(clock, length, b, c, nodes):
    """Times since the step's centre and weights of the nodes c of a step of that length."""
    if clock[ECCENTRICITY] >= 0.0:
        place_nodes(clock, 0.0, length, b, nodes)
    else:
        for j in range(nodes.shape[1]):
            nodes[OFFSET, j], nodes[WEIGHT, j] = (c[j] - 0.5) * length, length


@jit_inline
def states_in_steps(functions, numbers, tables, stretch, steps, scratch, outputs):
    """q, v (k, d) and codes (k,) <- states after times ``lengths`` (k,) since the starts of steps,
    by a shortened step each, whose passes converge.

    Parameters
    ----------
    steps
        bases (k, 4, m) as above; lengths; and the reference orbit's mean anomaly over 2 pi at the
        starts (k,)
    outputs
        (2, k, d), codes (k,) and counts; scratch as of galvi.lanes.frames.collocation, with a state
    """
    _, b, c, _, clock, _, _, coarse = tables
    bases, lengths, phases = steps
    states, codes, counts = outputs
    stages, coarse_stages, work, spare, state = scratch
    n, d, full_length, turns = (
        stages[0].shape[0] // 2,
        states.shape[2],
        numbers[LENGTH],
        clock[TURNS],
    )
    for k in range(bases.shape[0]):
        enter_base(bases[k], state)
        call_void(functions[DRIFT], numbers, -0.5, state)
        share = lengths[k] / full_length
        numbers[LENGTH], clock[TURNS], clock[PHASE] = lengths[k], turns * share, phases[k]
        call_void(functions[DRIFT], numbers, 0.5, state)
        if coarse[0].shape[0] > 0:
            stretch_nodes(coarse[2], stretch * share, coarse_stages[2])
            set_offsets(clock, lengths[k], coarse[1], coarse[2], coarse_stages[2])
        stretch_nodes(c, stretch * share, stages[2])
        set_offsets(clock, lengths[k], b, c, stages[2])
        codes[k] = solve_step(
            functions, numbers, tables, state, counts, stages, coarse_stages, work
        )
        add_rows(b, stages[1], state[4], state[5], 0, n)
        add_rows(b, stages[1], state[6], state[7], n, n)
        if not leave(functions, numbers, state, spare, d):
            codes[k] = SOLVED + 1
        for i in range(d):
            states[0, k, i], states[1, k, i] = state[0, i], state[2, i]
        numbers[LENGTH], clock[TURNS] = full_length, turns


@cache
def compiled_states_in_steps():
    """``states_in_steps`` compiled or cached."""
    steps = types.Tuple((BASES, VECTOR, VECTOR))
    scratch = types.Tuple((STAGES, STAGES, MATRIX, MATRIX, MATRIX))
    outputs = types.Tuple((PLACES, types.int64[::1], types.int64[::1]))
    signature = types.void(types.int64[::1], VECTOR, TABLES, types.float64, steps, scratch, outputs)
    return compiled_for(states_in_steps, signature, jit_inline)
