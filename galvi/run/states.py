"""States of a run at any times, with the order of its steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.engines import formulation_of, motion_in_clock
from galvi.run.in_frame.inertial import step_in_parts
from galvi.run.interruption import uninterrupted
from galvi.run.loop import run_steps, unwatched
from galvi.run.request import RunRequest, from_start
from galvi.run.vector_space import VECTOR_SPACE, reach_kernel
from galvi.systems.lagrangian import momentum_at, velocity_at
from galvi.systems.nbody import NBody
from galvi.trajectory import Trajectory

# Relative distance of a state from the curve, beyond which a shortened step in a frame is taken to
# have missed a passage.
FAR_FROM_CURVE = 1e-9
# Parts in which a shortened step in a clock is tried: without the run's guess it may fail where the
# run's step did not.
PARTS_OF_LAST_STEP = (1, 4, 16)


def states_at(run: Trajectory, times: Any) -> tuple[Array, Array]:
    """The states of a run at any times, with the order of its steps.

    Each state is reached by whole steps from the last saved state before it and one shortened step,
    so that it has the order of the steps' ends, 2 s with Gauss s; ``run(t)`` has the order of the
    curves. A shortened step that fails is repeated in parts in a clock, and in parts in the
    inertial frame for point masses in a moving frame. Where that fails too, the state is that on
    the curve.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of `galvi.integrate`
    times : float or array, shape (k,)
        times within the run, in any order

    Returns
    -------
    q, p : array, shape (k, ...), or that of one state for one time
        configurations and momenta

    Raises
    ------
    ValueError
        For times outside the run, of another shape or not finite, and for a run of another code.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), clock=galvi.Sundman())
    >>> run = galvi.integrate(galvi.problems.kepler(0.9), method, step=0.3, duration=6.0)
    >>> q, p = galvi.states_at(run, [1.0, 2.0, 3.0])
    >>> q.shape, p.shape, galvi.states_at(run, 6.0)[0] == run.q[-1]
    ((3, 2), (3, 2), array([ True,  True]))
    """
    if not isinstance(run, Trajectory) or run.step is None or run.checkpoint is None:
        raise ValueError(
            f"run must be a run of galvi.integrate, which has states between its steps; received "
            f"{shown(run)}."
        )
    time_values = input_checks.array("times", times)
    if time_values.ndim > 1:
        raise ValueError(f"times must be a scalar or (k,); received shape {time_values.shape}.")
    states, times_1d = RunStates(run), np.atleast_1d(time_values)
    first, last = states.grid[0], states.grid[-1]
    if not np.all((times_1d * states.sign >= first) & (times_1d * states.sign <= last)):
        raise ValueError(
            f"times must lie inside the run, from {float(run.t[0])!r} to {states.last!r}; "
            f"received {shown(times)}."
        )
    q, p, _ = states(times_1d)
    return (q, p) if np.ndim(times) else (q[0], p[0])


class RunStates:
    """The states of a run at times within it: q, p and v, (k, ...) each."""

    def __init__(self, run: Trajectory) -> None:
        self.run, self.sign = run, math.copysign(1.0, cast(float, run.step))
        finite_count = finite_states(run)
        self.grid, self.last = self.sign * run.t[:finite_count], float(run.t[finite_count - 1])

    def __call__(self, times: Array, stages: Array | None = None) -> tuple[Array, Array, Array]:
        """q, p and v at times (k,). ``stages`` (k, d, s), the stages of the last step to nearby
        times or 0, are changed in place to those of the last step."""
        run, wanted = self.run, self.sign * times
        rows = np.searchsorted(self.grid, wanted, side="right") - 1
        t, q, p, v = self.grid[rows], run.q[rows], run.p[rows], saved_velocities(run, rows)
        if run.restarts is not None:  # an action changed the state, from which the run went on
            restart_times = self.sign * run.restarts.t
            restart_rows = np.searchsorted(restart_times, wanted, side="right") - 1
            restarted = np.flatnonzero((restart_rows >= 0) & (restart_times[restart_rows] > t))
            restart_rows = restart_rows[restarted]
            t[restarted], q[restarted], v[restarted] = (
                restart_times[restart_rows],
                run.restarts.q[restart_rows],
                run.restarts.v[restart_rows],
            )
            system, times_of = run.problem.system, self.sign * t[restarted]
            p[restarted] = momentum_at(system, q[restarted], v[restarted], times_of)
        ahead = np.flatnonzero(wanted != t)
        if ahead.size:
            guess = None if stages is None else stages[ahead]
            arguments = q[ahead], v[ahead], self.sign * t[ahead], times[ahead]
            q[ahead], p[ahead], v[ahead] = self._replace_lost(
                self._reach(*arguments, guess), *arguments
            )
            if stages is not None:
                stages[ahead] = guess
        return q, p, v

    def _replace_lost(
        self,
        states: tuple[Array, Array, Array],
        positions: Array,
        velocities: Array,
        begin_times: Array,
        times: Array,
    ) -> tuple[Array, Array, Array]:
        """``states`` at ``times``, with the lost ones replaced in place.

        A state is lost where no shortened step could be done, and where one in a frame missed a
        passage that the run did in parts. In a frame it is reached in parts from the state
        (positions, velocities) at ``begin_times``; else, or where that fails, it becomes the state
        on the run's curve. Without curves it stays lost.
        """
        (q, p, v), run = states, self.run
        lost = ~np.isfinite(q.reshape(len(times), -1)).all(axis=1)
        is_in_frame, has_inertial_steps = _is_in_frame(run), run.counts.get("inertial_steps", 0) > 0
        if not (lost.any() or has_inertial_steps) or (run.curves is None and run.again is None):
            return q, p, v
        on_curves = run(times)
        if has_inertial_steps:
            deviation = np.abs(q - on_curves).reshape(len(times), -1).max(axis=1)
            lost |= ~(
                deviation <= FAR_FROM_CURVE * np.abs(on_curves).reshape(len(times), -1).max(axis=1)
            )
        for k in np.flatnonzero(lost).tolist():
            moved = run.problem.moved(positions[k], velocities[k], float(begin_times[k]))
            state = _in_parts(moved, float(times[k] - begin_times[k])) if is_in_frame else None
            if state is None:
                v[k] = run.velocity(times[k])
                momentum = momentum_at(
                    run.problem.system, on_curves[k][None], v[k][None], times[k : k + 1]
                )
                state = on_curves[k], momentum[0], v[k]
            q[k], p[k], v[k] = state
        return q, p, v

    @cached_property
    def _reach(self) -> Reach:
        run = self.run
        if run.tau is not None:
            return partial(_reach_one_by_one, _reach_in_clock(run))
        if formulation_of(run.problem, run.method) is VECTOR_SPACE:
            return partial(_reach_together, run, _reach_in_time(run))
        return partial(_reach_one_by_one, _reach_in_time(run))


def finite_states(run: Trajectory) -> int:
    """The number of saved states of a run before a step that failed."""
    if np.all(np.isfinite(run.q[-1])):
        return len(run.t)
    return int(np.count_nonzero(np.isfinite(run.q.reshape(len(run.t), -1)).all(axis=1)))


def saved_velocities(run: Trajectory, rows: Any) -> Array:
    """The velocities (k, ...) of the saved states at these rows."""
    if run.velocities is not None:
        return run.velocities[rows]
    distinct, inverse = np.unique(rows, return_inverse=True)  # each the guess of the next
    q, p, t, guess = run.q[distinct], run.p[distinct], run.t[distinct], run.problem.v0
    return velocity_at(run.problem.system, q, p, t, guess)[inverse]


Reach = Callable[..., tuple[Array, Array, Array]]  # of q, v, t, times and stages, to q, p and v


def _reach_one_by_one(
    reach: Reach, q: Array, v: Array, t: Array, times: Array, stages: Array | None = None
) -> tuple[Array, Array, Array]:
    columns = zip(
        *(reach(*row) for row in zip(q, v, t.tolist(), times.tolist(), strict=True)), strict=True
    )
    q, p, v = (np.array(x) for x in columns)
    return q, p, v


def _reach_together(
    run: Trajectory,
    reach: Reach,
    q: Array,
    v: Array,
    t: Array,
    times: Array,
    stages: Array | None = None,
) -> tuple[Array, Array, Array]:
    """`_reach_one_by_one` on a vector space, by one call of a kernel; states whose steps fail are
    reached one by one."""
    step, end, n = cast(float, run.step), cast(Checkpoint, run.checkpoint), len(t)
    kernel = reach_kernel(RunRequest(run.problem, run.method, step, 1, end))
    states, codes = np.zeros((n, 4, run.problem.q0.size)), np.zeros(n, dtype=np.int64)
    states[:, 0], states[:, 2] = q.reshape(n, -1), v.reshape(n, -1)
    if stages is None:
        stages = np.zeros((n, states.shape[2], run.method.stages))
    full_steps = ((times - t) / step).astype(np.int64)
    kernel(t, full_steps, times - (t + full_steps * step), states, stages, codes)
    ends = states[:, 0].reshape(q.shape), states[:, 2].reshape(v.shape)
    p = momentum_at(run.problem.system, *ends, times)
    for k in np.flatnonzero(codes).tolist():
        ends[0][k], p[k], ends[1][k] = reach(q[k], v[k], float(t[k]), float(times[k]))
    return ends[0], p, ends[1]


def _reach_in_clock(run: Trajectory) -> Reach:
    end, step = cast(Checkpoint, run.checkpoint), cast(float, run.step)
    motion_of_run = motion_in_clock(run.problem, run.method, end.solver, end.tolerance)

    def reach(q: Array, v: Array, t: float, time: float) -> tuple[Array, Array, Array]:
        motion = motion_of_run
        if run.restarts is not None:  # the states after actions have other energies
            moved = run.problem.moved(q, v, t)
            motion = motion_in_clock(moved, run.method, end.solver, end.tolerance)
        state = replace(motion.at(q, v, t), curves=False)
        for parts in PARTS_OF_LAST_STEP:
            request = RunRequest(run.problem, run.method, step / parts, None, state, time)
            inner_run = uninterrupted(run_steps(ClockStepper(request, motion), watched=False))
            if inner_run.t[-1] == time:
                break
        else:
            return np.full_like(q, np.nan), np.full_like(v, np.nan), np.full_like(v, np.nan)
        q, p = inner_run.q[-1], inner_run.p[-1]
        if inner_run.velocities is not None:
            return q, p, inner_run.velocities[-1]
        return q, p, velocity_at(run.problem.system, q[None], p[None], time, v)[0]

    return reach


def _is_in_frame(run: Trajectory) -> bool:
    """Whether a run is of point masses in a moving frame."""
    return cast(Galerkin, run.method).in_frame and isinstance(run.problem.system, NBody)


def _in_parts(start: Problem, length: float) -> tuple[Array, Array, Array] | None:
    """q, p and v of point masses after a time, by `step_in_parts`; None where no number of parts is
    enough."""
    work = step_in_parts(start, length)
    if work is None:
        return None
    q, v = (work.state[row].reshape(start.q0.shape) for row in (0, 2))
    return q, start.system.momentum(v), v


def _reach_in_time(run: Trajectory) -> Reach:
    end, step = cast(Checkpoint, run.checkpoint), cast(float, run.step)

    is_in_frame = _is_in_frame(run)

    def advance(q: Array, v: Array, t: float, h: float, n: int) -> tuple[Array, Array, Array]:
        moved = run.problem.moved(q, v, t)
        try:
            begin = from_start(end.solver, end.tolerance, n, curves=False)
            inner_run = unwatched(RunRequest(moved, run.method, h, n, begin))
            states = inner_run.q[-1], inner_run.p[-1], inner_run.v[-1]
        except ValueError:  # raised by a frame for orbits that are not bound there
            if not is_in_frame:
                raise
            states = np.full_like(q, np.nan), np.full_like(v, np.nan), np.full_like(v, np.nan)
        return states

    def reach(q: Array, v: Array, t: float, time: float) -> tuple[Array, Array, Array]:
        full_steps = int((time - t) / step)
        remainder = time - (t + full_steps * step)
        if full_steps:
            q, p, v = advance(q, v, t, step, full_steps)
            if remainder == 0.0 or not np.all(np.isfinite(q)):  # or a step failed
                return q, p, v
        state = advance(q, v, t + full_steps * step, remainder, 1)
        if abs(remainder) <= 2.0 * math.ulp(time) and not np.all(np.isfinite(state[0])):
            p = momentum_at(run.problem.system, q[None], v[None], np.array([t]))[0]
            return q, p, v  # a step of the last bit of time, which frames may fail to do
        return state

    return reach
