"""Many steps of a law in lanes: of one run, which is recorded, or of many members.

The step of a law is a function of the address of the arguments of galvi.lanes.layouts. The loops
call it by its own address, so that they are compiled once for all laws.
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
TERMS_INDEX = 3  # in solver_state: the number of terms to extrapolate


class OneRun(NamedTuple):
    """The arrays of a run in lanes, and the rows that hold its numbers.

    Attributes
    ----------
    arguments : array, shape (12,)
        of galvi.lanes.layouts
    record : array, shape (rows,)
        the numbers of the run
    seats : array, shape (n, 4)
        for each part of the state: its row and first column in the state of galvi.run.run_arrays,
        its first row in the record, and its size
    work : array, shape (rows, P)
        see galvi.lanes.layouts
    before : array, shape (2, n)
        q, and p or v, before a step
    layout : array, shape (factors, 5)
        of galvi.kernels.lie.product; no factors on R^d
    q, p
        first rows of the record for q, and for p or v
    shared
        first row of the record for the numbers of SHARED
    rates
        first row of work for the slopes of the curves at the stages
    velocities
        first row of work for the velocities at the stages
    last
        first row of work for the velocities at the stages of the last step
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
    """The matrices for the coefficients of a step's curve.

    Attributes
    ----------
    fit : array, shape (m, s)
        coefficients from the slopes at the stages, times h; with places_only those from the
        accelerations, times h^2
    line : array, shape (m,)
        with places_only, coefficients from the velocity at the start, times h; else shape (0,)
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
def run_part(law, address, arguments, part):
    """Run a part of the step of a law: PREPARE or STEP."""
    arguments[PART] = part
    call_void(law, address)


@jit_inline
def curve_of(fit, rates, out):
    """out (d, m) <- coefficients of a step's curve from its slopes (d, at least s) at the
    stages."""
    for i in range(out.shape[0]):
        for l in range(fit.shape[0]):
            coefficient = 0.0
            for j in range(fit.shape[1]):
                coefficient += fit[l, j] * rates[i, j]
            out[i, l] = coefficient


@jit_inline
def record_curve(plan, recording, step, curves, rates, velocities, before):
    """Record the curve of a step, if curves are kept, and its velocities at the stages, if the step
    is watched and they are."""
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
def enter_state(run, plan, state, stages, terms):
    """Copy the state into the record and the velocities at the stages into work, and set the shared
    numbers of the record."""
    numbers, shared, s = run.record, run.shared, stages.shape[1]
    numbers[shared + LENGTH], numbers[shared + START] = plan.step, plan.t0
    numbers[shared + ALIVE], numbers[shared + TERMS] = 1.0, terms
    if run.layout.shape[0] > 0 and memory_is_empty(state):
        product.remember(run.layout, state[0], state[2])
    for row, column, first, count in run.seats:
        for k in range(count):
            numbers[first + k] = state[row, column + k]
    for i in range(stages.shape[0]):
        for k in range(run.work.shape[1]):
            run.work[run.velocities + i, k] = stages[i, min(k, s - 1)]


@jit_inline
def leave_state(run, state, velocities, stages):
    """Copy the record into the state, and ``velocities`` into the stages."""
    for row, column, first, count in run.seats:
        for k in range(count):
            state[row, column + k] = run.record[first + k]
    copy_rows(stages, velocities)


@jit_inline
def memory_is_empty(state):
    """Whether the memory of galvi.kernels.lie.product is all 0, as after steps of another
    kernel."""
    size = 0.0
    for i in range(state.shape[1]):
        size += abs(state[2, i])
    return size == 0.0


@jit_inline
def advance_run(law, address, run, curves, plan, todo, progress, recording):
    """Do ``todo`` more steps; returns SOLVED, or the code of a step that failed, which leaves the
    state as it was before this step."""
    run, curves, plan = OneRun(*run), Curves(*curves), Plan(*plan)
    progress, recording = Progress(*progress), Recording(*recording)
    state, stages, solver_state = progress.state, progress.stages, progress.solver_state
    arguments, numbers, shared, before = run.arguments, run.record, run.shared, run.before
    (d, s), r, passage = stages.shape, recording.q.shape[1], progress.passage
    q, p = numbers[run.q : run.q + r], numbers[run.p : run.p + d]
    velocities = run.work[run.velocities : run.velocities + d]
    last, rates = run.work[run.last : run.last + d], run.work[run.rates : run.rates + d]
    enter_state(run, plan, state, stages, solver_state[TERMS_INDEX])
    run_part(law, address, arguments, PREPARE)
    for number in range(solver_state[DONE], solver_state[DONE] + todo):
        arguments[NUMBER] = plan.first + number
        arguments[CONTINUES] = 1 if solver_state[HOLDS] == LAST_STEP else 0
        numbers[shared + PASSES] = 0.0
        if recording.bases.shape[0] + passage.size > 0:
            for i in range(r):
                before[0, i] = q[i]
            for i in range(d):
                before[1, i] = p[i]
        run_part(law, address, arguments, STEP)
        passes = int(numbers[shared + PASSES])
        progress.counts[solve.ITERATIONS] += passes
        progress.counts[solve.FORCES] += passes * s
        if numbers[shared + ALIVE] == 0.0:
            leave_state(run, state, last, stages)
            return int(numbers[shared + CODE])
        solver_state[HOLDS], solver_state[DONE] = LAST_STEP, number + 1
        solver_state[TERMS_INDEX] = int(numbers[shared + TERMS])
        record(plan, recording, number, before[0], q, p)
        record_curve(plan, recording, number, curves, rates, velocities, before)
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
    leave_state(run, state, velocities, stages)
    return solve.SOLVED


@jit_inline
def copy_lanes(source, out):
    """out <- source, one number for each of eight members."""
    for k in range(LANES):
        out[k] = source[k]


@jit_inline
def advance_members(
    law, address, arguments, records, constants, work, velocities, first, number, todo
):
    """Do ``todo`` steps of all members, from step ``number`` on.

    Parameters
    ----------
    records, constants : array, shape (blocks, rows, 8)
        a block for eight members
    work : array, shape (rows, s, 8)
        scratch of one block
    velocities, first
        first rows of work and of a record for the velocities at the stages
    """
    d, s = (records.shape[1] - first) // work.shape[1], work.shape[1]
    record_address, constant_address = arguments[RECORD], arguments[CONSTANTS]
    for block in range(records.shape[0]):
        arguments[RECORD] = record_address + 8 * LANES * block * records.shape[1]
        arguments[CONSTANTS] = constant_address + 8 * LANES * block * constants.shape[1]
        for i in range(d * s):
            copy_lanes(records[block, first + i], work[velocities + i // s, i % s])
        run_part(law, address, arguments, PREPARE)
        for k in range(number, number + todo):
            arguments[NUMBER] = k
            arguments[CONTINUES] = 1 if k > 0 else 0
            run_part(law, address, arguments, STEP)
        for i in range(d * s):
            copy_lanes(work[velocities + i // s, i % s], records[block, first + i])
    arguments[RECORD], arguments[CONSTANTS] = record_address, constant_address


@cache
def compiled_advance_run():
    """The compiled ``advance_run``, one kernel for all laws."""
    integer = types.int64
    signature = integer(integer, integer, ONE_RUN, CURVES, PLAN, integer, PROGRESS, RECORDING)
    return compiled_for(advance_run, signature, jit_inline)


@cache
def compiled_advance_members():
    """The compiled ``advance_members``, one kernel for all laws."""
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
