"""Arguments shared by all kernels that advance a run, and the recording of results.

Kernels are called with plain tuples, whose types numba determines several times faster than those
of named tuples, and convert them at their start.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types

from galvi.kernels.compile.array_types import MATRIX, TENSOR3
from galvi.kernels.compile.jit import jit_inline


class Plan(NamedTuple):
    """The steps of a run.

    t0         time of the problem's start
    step       size h of a step
    tolerance  relative change at which a step's iteration stops
    first      number of the run's first step since the problem's start
    total      steps of the run
    every      number of steps between saved states
    """

    t0: float
    step: float
    tolerance: float
    first: int
    total: int
    every: int


class Progress(NamedTuple):
    """The current state of a run, updated by each kernel; for rows see the kernels.

    state (4, n), stages (d, s), solver_state (3 or more,), counts (4 or 5,)
    """

    state: Any
    stages: Any
    solver_state: Any
    counts: Any


class Kept(NamedTuple):
    """The kept results of a run.

    q, p           (saved, r), (saved, d)  rows 1, 2, ... are steps every, 2 every, ...; the last
                   row is the final state
    bases, curves  (steps, r), (steps, d, m); no rows when curves are not kept
    """

    q: Any
    p: Any
    bases: Any
    curves: Any


PLAN = types.Tuple((types.float64,) * 3 + (types.int64,) * 3)
PROGRESS = types.Tuple((MATRIX, MATRIX, types.int64[::1], types.int64[::1]))
KEPT = types.Tuple((MATRIX, MATRIX, MATRIX, TENSOR3))


@jit_inline
def record(plan, kept, step, start, q, p):
    """Record the (step + 1)-th step, from ``start`` to (q, p), except its curve coefficients."""
    row, rest = divmod(step + 1, plan.every)
    if step + 1 == plan.total:
        row, rest = kept.q.shape[0] - 1, 0
    if rest == 0:
        for i in range(kept.q.shape[1]):
            kept.q[row, i] = q[i]
        for i in range(kept.p.shape[1]):
            kept.p[row, i] = p[i]
    if kept.bases.shape[0] > 0:
        for i in range(kept.bases.shape[1]):
            kept.bases[step, i] = start[i]
