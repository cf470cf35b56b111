"""Places on the curves of many steps in a frame, and states after a part of such a step."""

from __future__ import annotations

import math
from functools import cache

from numba import types

from galvi.fast.lanes.frames.collocation import STAGES, TABLES, leave, solve_step
from galvi.fast.lanes.frames.rows import (
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
from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, VECTOR, compiled_for, jit_inline
from galvi.kernels.nystrom.solve import SOLVED

DRIFT, LEAVE = 1, 2  # of the addresses
LENGTH = 0  # of the numbers: that of the step
EVEN = 1e-8  # stretch up to which nodes stay where they are
BASES = types.Array(types.float64, 3, "C", readonly=True)
PLACES = types.Array(types.float64, 3, "C")


@jit_inline
def enter_base(base, state):
    """Rows 4 to 7 of the state (8, m) from the base (4, m) of a curve."""
    for i in range(base.shape[1]):
        state[4, i], state[6, i] = base[0, i], base[1, i]
        state[5, i], state[7, i] = base[2, i], base[3, i]


@jit_inline
def places_in_steps(functions, numbers, bases, ways, shares, state, q):
    """q (k, P, d) <- places on k steps at P places of each.

    bases   (k, 4, m) states at the steps' centres and their low parts
    ways    (k, P, 2 n) from them to w
    shares  (k, P) of a step, from its centre
    """
    n = ways.shape[2] // 2
    for k in range(bases.shape[0]):
        for j in range(ways.shape[1]):
            enter_base(bases[k], state)
            for i in range(n):
                state[4, i] += ways[k, j, i]
                state[6, i] += ways[k, j, n + i]
            call_void(functions[DRIFT], numbers, shares[k, j], state)
            call_void(functions[LEAVE], numbers, state)
            for i in range(q.shape[2]):
                q[k, j, i] = state[0, i]


@cache
def compiled_places_in_steps():
    """``places_in_steps`` compiled or cached."""
    signature = types.void(types.int64[::1], VECTOR, BASES, BASES, MATRIX, MATRIX, PLACES)
    return compiled_for(places_in_steps, signature, jit_inline)


@jit_inline
def stretch_nodes(c, stretch, nodes):
    """Places in [-1, 1] and slopes of the nodes c, as galvi.fast.in_frame.stepper.stretched."""
    for j in range(c.size):
        y = 2.0 * c[j] - 1.0
        nodes[PLACE, j], nodes[PACE, j] = y, 1.0
        if stretch >= EVEN:
            whole = math.asin(stretch)
            nodes[PLACE, j] = math.asin(stretch * y) / whole
            nodes[PACE, j] = stretch / whole / math.sqrt(1.0 - (stretch * y) ** 2)


@jit_inline
def set_offsets(clock, length, b, c, nodes):
    """Times since the step's centre and weights of the nodes c of a step of that length."""
    if clock[ECCENTRICITY] >= 0.0:
        place_nodes(clock, 0.0, length, b, nodes)
    else:
        for j in range(nodes.shape[1]):
            nodes[OFFSET, j], nodes[WEIGHT, j] = (c[j] - 0.5) * length, length


@jit_inline
def states_in_steps(functions, numbers, tables, stretch, steps, scratch, found):
    """q, v (k, d) and codes (k,) <- states after times ``lengths`` (k,) since the starts of steps,
    by a shortened step each, whose passes converge.

    steps   bases (k, 4, m) as above; lengths; and the reference orbit's mean anomaly over 2 pi at
            the starts (k,)
    found   (2, k, d), codes (k,) and counts; scratch as of galvi.fast.lanes.frames.collocation,
            with a state
    """
    _, b, c, _, clock, _, _, coarse = tables
    bases, lengths, phases = steps
    states, codes, counts = found
    stages, coarse_stages, work, spare, state = scratch
    n, d, whole, turns = stages[0].shape[0] // 2, states.shape[2], numbers[LENGTH], clock[TURNS]
    for k in range(bases.shape[0]):
        enter_base(bases[k], state)
        call_void(functions[DRIFT], numbers, -0.5, state)
        share = lengths[k] / whole
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
        numbers[LENGTH], clock[TURNS] = whole, turns


@cache
def compiled_states_in_steps():
    """``states_in_steps`` compiled or cached."""
    steps = types.Tuple((BASES, VECTOR, VECTOR))
    scratch = types.Tuple((STAGES, STAGES, MATRIX, MATRIX, MATRIX))
    found = types.Tuple((PLACES, types.int64[::1], types.int64[::1]))
    signature = types.void(
        types.int64[::1], VECTOR, TABLES, types.float64, steps, scratch, found
    )  # fmt: skip
    return compiled_for(states_in_steps, signature, jit_inline)
