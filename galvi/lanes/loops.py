"""Many steps of a law in lanes: of one run, which is recorded, or of many members.

A law's step is a function of the address of the arguments of galvi.lanes.layouts, which is itself
called by address: these loops are compiled once for all laws.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from numba import types

from galvi.kernels.compile.function_pointers import call_void
from galvi.kernels.compile.jit import MATRIX, TENSOR3, compiled_for, jit_inline
from galvi.kernels.forces.passages import near_limit, note_passages
from galvi.kernels.lie import product
from galvi.kernels.nystrom import solve
from galvi.kernels.nystrom.advance import DONE, HOLDS, LAST_STEP
from galvi.kernels.nystrom.step import FIXED_MATRIX, FIXED_VECTOR
from galvi.kernels.run_record import (
    PLAN,
    PROGRESS,
    RECORDING,
    Plan,
    Progress,
    Recording,
    record,
    watched_row,
)
from galvi.lanes.layouts import CONSTANTS, CONTINUES, NUMBER, PART, RECORD, SHARED
from galvi.lanes.nbody import copy_rows
from galvi.lanes.step import PREPARE, STEP
from galvi.lanes.vectors import LANES

STEP_OF_LAW = types.void(types.int64)
LENGTH, START, ALIVE, CODE, PASSES, TERMS = (
    SHARED.index(name) for name in ("step", "start", "alive", "code", "passes", "terms")
)
TERMS_KEPT = 3  # index in solver_state


class OneRun(NamedTuple):
    """The arrays of a run in lanes, and where its numbers are.

    Attributes
    ----------
    arguments : array, shape (12,)
        of galvi.lanes.layouts
    record : array, shape (rows,)
        the numbers of the run
    seats : array, shape (n, 4)
        of each part of the state: row and first column in galvi.run.run_arrays' state, first row
        in the record, and size
    work : array, shape (rows, P)
    before : array, shape (2, n)
        q and p, or v, before a step
    layout : array, shape (factors, 5)
        of galvi.kernels.lie.product; no factors on R^d
    q, p
        first rows of the record for these
    shared
        first row of the record for the numbers of SHARED
    rates
        first row of work for the rates of curves
    velocities
        first row of work for the velocities at the stages
    last
        first row of work for those of the last step
    """

    arguments: Any
    record: Any
    seats: Any
    work: Any
    before: Any
    layout: Any
    q: int
    p: int
    shared: int
    rates: int
    velocities: int
    last: int


class Curves(NamedTuple):
    """What gives the coefficients of a step's curve.

    Attributes
    ----------
    fit : array, shape (m, s)
        h times its coefficients from the rates at the stages; with places_only h^2 times those
        from the accelerations
    line : array, shape (m,)
        with places_only, h times its coefficients from the velocity; else (0,)
    c : array, shape (P,)
        nodes
    """

    fit: Any
    line: Any
    c: Any


ONE_RUN = types.Tuple(
    (types.int64[::1], types.float64[::1], types.int64[:, ::1], MATRIX, MATRIX)
    + (types.int64[:, ::1],)
    + (types.int64,) * 6
)
CURVES = types.Tuple((FIXED_MATRIX, FIXED_VECTOR, FIXED_VECTOR))


@jit_inline
def do(law, address, arguments, part):
    """Do a part of a step."""
    arguments[PART] = part
    call_void(law, address)


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
def keep(plan, recording, step, curves, rates, velocities, before):
    """Record the curve of a step from q and v, and its velocities where it is watched."""
    fit, line, d = curves.fit, curves.line, velocities.shape[0]
    if recording.bases.shape[0] > 0:
        curve_of(fit, rates, recording.curves[step])
        for l in range(line.size):
            for i in range(d):
                recording.curves[step, i, l] += line[l] * before[1, i]
    row, first = watched_row(plan, recording, step), recording.q.shape[1] + recording.p.shape[1]
    if row >= 0 and recording.watched.shape[1] > first:
        s = fit.shape[1]
        for i in range(d):
            for j in range(s):
                recording.watched[row, first + i * s + j] = velocities[i, j]


@jit_inline
def begin(run, plan, state, stages, terms):
    """Copy the state and the velocities at the stages into the record and work."""
    numbers, shared, s = run.record, run.shared, stages.shape[1]
    numbers[shared + LENGTH], numbers[shared + START] = plan.step, plan.t0
    numbers[shared + ALIVE], numbers[shared + TERMS] = 1.0, terms
    if run.layout.shape[0] > 0 and nothing_remembered(state):
        product.remember(run.layout, state[0], state[2])
    for row, column, first, count in run.seats:
        for k in range(count):
            numbers[first + k] = state[row, column + k]
    for i in range(stages.shape[0]):
        for k in range(run.work.shape[1]):
            run.work[run.velocities + i, k] = stages[i, min(k, s - 1)]


@jit_inline
def put_back(run, state, velocities, stages):
    """Copy the record and the velocities back into the state and the stages."""
    for row, column, first, count in run.seats:
        for k in range(count):
            state[row, column + k] = run.record[first + k]
    copy_rows(stages, velocities)


@jit_inline
def nothing_remembered(state):
    """Whether the memory of galvi.kernels.lie.product is empty, as after a step elsewhere."""
    size = 0.0
    for i in range(state.shape[1]):
        size += abs(state[2, i])
    return size == 0.0


@jit_inline
def advance_run(law, address, run, curves, plan, todo, progress, recording):
    """Do ``todo`` more steps; returns a code. A step that fails leaves the state unchanged."""
    run, curves, plan = OneRun(*run), Curves(*curves), Plan(*plan)
    progress, recording = Progress(*progress), Recording(*recording)
    state, stages, solver_state = progress.state, progress.stages, progress.solver_state
    arguments, numbers, shared, before = run.arguments, run.record, run.shared, run.before
    (d, s), r, passage = stages.shape, recording.q.shape[1], progress.passage
    q, p = numbers[run.q : run.q + r], numbers[run.p : run.p + d]
    velocities = run.work[run.velocities : run.velocities + d]
    last, rates = run.work[run.last : run.last + d], run.work[run.rates : run.rates + d]
    begin(run, plan, state, stages, solver_state[TERMS_KEPT])
    do(law, address, arguments, PREPARE)
    for number in range(solver_state[DONE], solver_state[DONE] + todo):
        arguments[NUMBER] = plan.first + number
        arguments[CONTINUES] = 1 if solver_state[HOLDS] == LAST_STEP else 0
        numbers[shared + PASSES] = 0.0
        if recording.bases.shape[0] + passage.size > 0:
            for i in range(r):
                before[0, i] = q[i]
            for i in range(d):
                before[1, i] = p[i]
        do(law, address, arguments, STEP)
        passes = int(numbers[shared + PASSES])
        progress.counts[solve.ITERATIONS] += passes
        progress.counts[solve.FORCES] += passes * s
        if numbers[shared + ALIVE] == 0.0:
            put_back(run, state, last, stages)
            return int(numbers[shared + CODE])
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, number + 1
        solver_state[TERMS_KEPT] = int(numbers[shared + TERMS])
        record(plan, recording, number, before[0], q, p)
        keep(plan, recording, number, curves, rates, velocities, before)
        if passage.size > 0:
            m, h = curves.fit.shape[0], plan.step
            fast, slow = near_limit(passage, velocities[:, 0], h, m)
            note_passages(
                passage,
                run.work[:d],
                curves.c[:s],
                before[0],
                q,
                h,
                m,
                max(fast, slow ** (2.0 / 3.0)),
                plan.first + number + 1,
            )
    put_back(run, state, velocities, stages)
    return solve.SOLVED


@jit_inline
def copy_lanes(source, out):
    """out <- the numbers of eight members."""
    for k in range(LANES):
        out[k] = source[k]


@jit_inline
def advance_members(
    law, address, arguments, records, constants, work, velocities, first, number, todo
):
    """Do ``todo`` steps of all members from the number-th on.

    Parameters
    ----------
    records, constants : array, shape (blocks, rows, 8)
        for eight members each
    work : array, shape (rows, s, 8)
    velocities, first
        the first rows of work and of a record for the velocities at the stages
    """
    d, s = (records.shape[1] - first) // work.shape[1], work.shape[1]
    record_address, constant_address = arguments[RECORD], arguments[CONSTANTS]
    for block in range(records.shape[0]):
        arguments[RECORD] = record_address + 8 * LANES * block * records.shape[1]
        arguments[CONSTANTS] = constant_address + 8 * LANES * block * constants.shape[1]
        for i in range(d * s):
            copy_lanes(records[block, first + i], work[velocities + i // s, i % s])
        do(law, address, arguments, PREPARE)
        for k in range(number, number + todo):
            arguments[NUMBER] = k
            arguments[CONTINUES] = 1 if k > 0 else 0
            do(law, address, arguments, STEP)
        for i in range(d * s):
            copy_lanes(work[velocities + i // s, i % s], records[block, first + i])
    arguments[RECORD], arguments[CONSTANTS] = record_address, constant_address


@cache
def compiled_advance_run():
    """``advance_run`` compiled or cached, one kernel for all laws."""
    integer = types.int64
    signature = integer(integer, integer, ONE_RUN, CURVES, PLAN, integer, PROGRESS, RECORDING)
    return compiled_for(advance_run, signature, jit_inline)


@cache
def compiled_advance_members():
    """``advance_members`` compiled or cached, one kernel for all laws."""
    integer = types.int64
    signature = types.void(
        integer,
        integer,
        types.int64[::1],
        TENSOR3,
        TENSOR3,
        TENSOR3,
        integer,
        integer,
        integer,
        integer,
    )
    return compiled_for(advance_members, signature, jit_inline)
