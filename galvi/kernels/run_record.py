"""Arguments shared by all kernels that advance a run, and the recording of steps.

Kernels are called with plain tuples, whose types numba determines several times faster than those
of named tuples, and convert them at their start.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types

from galvi.kernels.compile.jit import MATRIX, TENSOR3, VECTOR, jit_inline


class Plan(NamedTuple):
    """The steps of a run.

    Attributes
    ----------
    t0
        time of the problem's start
    step
        size h of a step
    tolerance
        relative change at which a step's iteration stops
    first
        number of the run's first step since the problem's start
    total
        steps of the run
    save_every
        number of steps between saved states
    watch
        every 2^watch-th step since the problem's start is recorded to assess the energy
    """

    t0: float
    step: float
    tolerance: float
    first: int
    total: int
    save_every: int
    watch: int


class Progress(NamedTuple):
    """The current state of a run, which kernels update; their docstrings describe the rows.

    Attributes
    ----------
    state : array, shape (4, n)
    stages : array, shape (d, s)
    solver_state : array, shape (3 or more,)
    counts : array, shape (7,)
    passage
        see galvi.kernels.forces.passages; (0,) without pairs of point masses
    """

    state: Any
    stages: Any
    solver_state: Any
    counts: Any
    passage: Any


class Recording(NamedTuple):
    """The recorded states and curves of a run.

    Attributes
    ----------
    q, p : array, shape (saved, r), (saved, d)
        row k is the state after k save_every steps; the last row is the final state
    bases, curves : array, shape (steps, r), (steps, d, m)
        start and coefficients of each step's curve; no rows if curves are not recorded
    watched : array, shape (watched, r + d or more)
        q and p after the watched steps; on groups whose energy needs the velocities, followed by
        the stages (d, s)
    """

    q: Any
    p: Any
    bases: Any
    curves: Any
    watched: Any


PLAN = types.Tuple((types.float64,) * 3 + (types.int64,) * 4)
PROGRESS = types.Tuple((MATRIX, MATRIX, types.int64[::1], types.int64[::1], VECTOR))
RECORDING = types.Tuple((MATRIX, MATRIX, MATRIX, TENSOR3, MATRIX))


@jit_inline
def watched_row(plan, recording, step):
    """The row of ``watched`` for the (step + 1)-th step; -1 if it has none."""
    number = plan.first + step + 1
    if number & ((1 << plan.watch) - 1) != 0:
        return -1
    row = (number >> plan.watch) - (plan.first >> plan.watch) - 1
    return row if row < recording.watched.shape[0] else -1


@jit_inline
def record(plan, recording, step, start, q, p):
    """Record the (step + 1)-th step, from ``start`` to (q, p), without its curve's coefficients."""
    row, remainder = divmod(step + 1, plan.save_every)
    if step + 1 == plan.total:
        row, remainder = recording.q.shape[0] - 1, 0
    if remainder == 0:
        for i in range(recording.q.shape[1]):
            recording.q[row, i] = q[i]
        for i in range(recording.p.shape[1]):
            recording.p[row, i] = p[i]
    if recording.bases.shape[0] > 0:
        for i in range(recording.bases.shape[1]):
            recording.bases[step, i] = start[i]
    row = watched_row(plan, recording, step)
    if row >= 0:
        for i in range(recording.q.shape[1]):
            recording.watched[row, i] = q[i]
        for i in range(recording.p.shape[1]):
            recording.watched[row, recording.q.shape[1] + i] = p[i]
