"""States within steps of a run, for many steps at once: each by a shortened step from the state
before the whole one."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import FrameCurves
from galvi.events.block import Block
from galvi.kernels.nystrom.solve import SOLVED
from galvi.problem import Problem
from galvi.run.clocked.motion import Motion
from galvi.run.engines import motion_in_clock
from galvi.run.states import saved_velocities
from galvi.systems.lagrangian import velocity_at


class ShortenedSteps(NamedTuple):
    """Shortened steps of n steps of a run, some of which may be the same.

    Attributes
    ----------
    after
        (u, rows) -> q, v and t at u (k,) in the steps ``rows`` (k,) of the n; q is NaN where a
        shortened step could not be done
    low, high : array, shape (n,)
        limits of u, which is the time, or in a clock the length of the shortened step in tau
    begin, pace : array, shape (n,)
        u and dt/du at the requested x
    """

    after: Callable[[Array, Any], tuple[Array, Array, Array]]
    low: Array
    high: Array
    begin: Array
    pace: Array


def shortened_steps(block: Block, steps: Any, x: Array) -> ShortenedSteps | None:
    """Shortened steps of the ``steps`` (n,) of a block, to be started at x (n,) in [-1, 1]; None
    where states must be reached one by one."""
    curves = block.piece.curves
    if isinstance(curves, FrameCurves):
        return _in_frame(block, curves, steps, x)
    if isinstance(curves, ClockCurves) and block.piece.has_states:
        return _in_clock(block, curves, steps, x)
    return None


def _in_frame(block: Block, curves: FrameCurves, steps: Any, x: Array) -> ShortenedSteps | None:
    problem, index = block.piece.run.problem, block.first + steps
    if curves.path.states(curves.bases[:0], index[:0], np.zeros(0)) is None:
        return None
    bases, numbers = np.ascontiguousarray(curves.bases[index]), curves.first + index
    begin, is_inertial = block.begin[steps], np.isnan(curves.coefficients[index, -1, -1])
    t, pace = block.times(steps, x)

    def after(t: Array, rows: Any) -> tuple[Array, Array, Array]:
        q, v, codes = cast(Any, curves.path.states(bases[rows], numbers[rows], t - begin[rows]))
        failed = (codes != SOLVED) | is_inertial[rows]
        q[failed] = np.nan
        at_start = np.flatnonzero(t == begin[rows])
        if at_start.size:  # a step of no length
            q[at_start] = np.nan
        return q.reshape(-1, *problem.q0.shape), v.reshape(-1, *problem.v0.shape), t

    end = block.end[steps]
    return ShortenedSteps(
        after, np.minimum(begin, end), np.maximum(begin, end), t, np.ones_like(pace)
    )


def _in_clock(block: Block, curves: ClockCurves, steps: Any, x: Array) -> ShortenedSteps:
    run, index = block.piece.run, block.first + steps
    end = cast(Checkpoint, run.checkpoint)
    motion = motion_in_clock(run.problem, run.method, end.solver, end.tolerance)
    lengths = np.where(index == len(curves.rates) - 1, curves.last, curves.step)
    q0, v0, t0 = run.q[index], saved_velocities(run, index), run.t[index]
    states: dict[int, Checkpoint] = {}

    def after(u: Array, rows: Any) -> tuple[Array, Array, Array]:
        for row in rows.tolist():
            if row not in states:
                states[row] = motion.at(q0[row], v0[row], float(t0[row]))
        states_before = [states[row] for row in rows.tolist()]
        q, v, t, codes = (motion.single_steps or partial(_single_steps, motion, run.problem))(
            states_before, u
        )
        q, v = q.reshape(-1, *q0.shape[1:]), v.reshape(-1, *v0.shape[1:])
        q[codes != SOLVED] = np.nan
        is_at_start = u == 0.0
        q[is_at_start], v[is_at_start], t[is_at_start] = (
            q0[rows[is_at_start]],
            v0[rows[is_at_start]],
            t0[rows[is_at_start]],
        )
        return q, v, t

    _, slope = block.times(steps, x)
    limits = np.minimum(lengths, 0.0), np.maximum(lengths, 0.0)
    return ShortenedSteps(after, *limits, 0.5 * (1.0 + x) * lengths, slope * 2.0 / lengths)


def _single_steps(
    motion: Motion, problem: Problem, states: list[Checkpoint], lengths: Array
) -> tuple[Array, Array, Array, Any]:
    """As `Motion.single_steps`, by `Motion.advance`."""
    n, codes = len(states), np.full(len(states), SOLVED)
    q, v, t = np.empty((n, problem.q0.size)), np.empty((n, problem.v0.size)), np.empty(n)
    for k, length in enumerate(lengths.tolist()):
        if length == 0.0:
            continue
        advanced = motion.advance(states[k], length, 1, None, False)
        codes[k] = advanced.code
        if advanced.code == SOLVED:
            steps = advanced.steps
            q[k], t[k] = steps.q[0], steps.t[0].sum()
            if steps.v is not None:
                v[k] = steps.v[0]
                continue
            configuration, p = (
                q[k].reshape(1, *problem.q0.shape),
                steps.p.reshape(1, *problem.v0.shape),
            )
            v[k] = velocity_at(problem.system, configuration, p, t[k], problem.v0).ravel()
    return q, v, t, codes
