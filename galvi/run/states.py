"""States of a run at any times, of the order of its steps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.input_checks import shown
from galvi.kernels.nystrom.solve import SOLVED
from galvi.run.clocked.loop import Loop
from galvi.run.clocked.run import motion_of
from galvi.run.engine_choice import engine_for
from galvi.run.interruption import uninterrupted
from galvi.run.loop import run_steps
from galvi.run.nystrom_engine import NYSTROM
from galvi.run.nystrom_steppers import general_stepper
from galvi.run.plan import Run
from galvi.systems.velocities import momentum_at, velocity_at
from galvi.trajectory import Trajectory

GENERAL = replace(NYSTROM, stepper=general_stepper, stepper_from_guess=general_stepper)
AHEAD = 8  # steps in a clock that are tried at once on the way to a time
PARTS = (1, 4, 16)  # of a step there: the first, which has no guess, may fail where it did not


def states_at(run: Trajectory, times: Any) -> tuple[Array, Array]:
    """States (q, p) at any times of a run, (k, ...) each, or of a scalar those of one time.

    Each is reached by whole steps from the last kept state before it and one shortened step, so
    that it has the order of the steps' ends, 2 s with Gauss s; ``run(t)``, on the curves, has
    theirs. NaN where such a step fails. Raises ValueError outside the run and for a run of a
    reference.
    """
    q, p, _ = states_between(run, times)
    return (q, p) if np.ndim(times) else (q[0], p[0])


def states_between(run: Trajectory, times: Any) -> tuple[Array, Array, Array]:
    """As `states_at`, with the velocities, (k, ...) each."""
    if not isinstance(run, Trajectory) or run.step is None or run.checkpoint is None:
        raise ValueError(
            f"states between steps are those of a run of galvi.integrate; received {shown(run)}."
        )
    wanted = input_checks.array("times", times)
    if wanted.ndim > 1:
        raise ValueError(f"times must be a scalar or (k,); received shape {wanted.shape}.")
    reaching, flat = Reaching(run), np.atleast_1d(wanted)
    if not np.all((flat * reaching.sign >= reaching.grid[0])
                  & (flat * reaching.sign <= reaching.grid[-1])):  # fmt: skip
        raise ValueError(
            f"times must lie inside the run, from {float(run.t[0])!r} to {reaching.last!r}; "
            f"received {shown(times)}."
        )
    q = np.empty((len(flat), *run.q.shape[1:]))
    p, v = (np.empty((len(flat), *run.p.shape[1:])) for _ in "pv")
    for k, time in enumerate(flat.tolist()):
        q[k], p[k], v[k] = reaching(time)
    return q, p, v


class Reaching:
    """The state of a run at a time within it: q, p and v."""

    def __init__(self, run: Trajectory) -> None:
        self.run, self.sign = run, math.copysign(1.0, cast(float, run.step))
        good = int(np.count_nonzero(np.isfinite(run.q.reshape(len(run.t), -1)).all(axis=1)))
        self.grid, self.last = self.sign * run.t[:good], float(run.t[good - 1])
        self._reach: Reach | None = None

    def __call__(self, time: float) -> tuple[Array, Array, Array]:
        run, wanted = self.run, self.sign * time
        row = int(np.searchsorted(self.grid, wanted, side="right")) - 1
        t, q, p = self.grid[row], run.q[row], run.p[row]
        v = self._velocity(row)
        if run.restarts is not None:  # of an action, from which the run went on
            k = int(np.searchsorted(self.sign * run.restarts.t, wanted, side="right")) - 1
            if k >= 0 and self.sign * run.restarts.t[k] > t:
                t, q, v = self.sign * run.restarts.t[k], run.restarts.q[k], run.restarts.v[k]
                p = momentum_at(run.problem.system, q, v, self.sign * t)
        if wanted == t:
            return q, p, v
        if self._reach is None:
            self._reach = _reach_in_clock(run) if run.tau is not None else _reach_in_time(run)
        return self._reach(q, v, self.sign * float(t), time)

    def _velocity(self, row: int) -> Array:
        run, here = self.run, slice(row, row + 1)
        if run.velocities is not None:
            return run.velocities[row]
        system, near = run.problem.system, run.problem.v0
        found: Array = velocity_at(system, run.q[here], run.p[here], run.t[here], near)[0]
        return found


Reach = Callable[[Array, Array, float, float], tuple[Array, Array, Array]]  # of q, v, t and a time


def _reach_in_clock(run: Trajectory) -> Reach:
    end, step = cast(Checkpoint, run.checkpoint), cast(float, run.step)
    fixed = motion_of(run.problem, run.method, end.solver, end.tolerance)

    def reach(q: Array, v: Array, t: float, time: float) -> tuple[Array, Array, Array]:
        motion = fixed
        if run.restarts is not None:  # which have energies of their own
            here = run.problem.moved(q, v, t)
            motion = motion_of(here, run.method, end.solver, end.tolerance)
        state = replace(motion.at(q, v, t), curves=False)
        for parts in PARTS:
            loop = Loop(run.problem, run.method, step / parts, motion, state, time)
            while not loop.over and loop.call(AHEAD) == SOLVED:
                pass
            found, _ = loop.to_time() if loop.reached else (None, 0.0)
            if found is None and loop.reached:  # at the grid point
                found = loop.last
            if found is not None:
                break
        if found is None:
            return np.full_like(q, np.nan), np.full_like(v, np.nan), np.full_like(v, np.nan)
        q, p = found.q[0].reshape(q.shape), found.p[0].reshape(v.shape)
        if found.v is not None:
            return q, p, found.v[0].reshape(v.shape)
        return q, p, velocity_at(run.problem.system, q[None], p[None], time, v)[0]

    return reach


def _reach_in_time(run: Trajectory) -> Reach:
    end, step = cast(Checkpoint, run.checkpoint), cast(float, run.step)

    engine = engine_for(run.problem, run.method)
    if engine is NYSTROM and engine.is_compiled(run.problem, run.method):
        engine = GENERAL  # lanes make tables of each length of a step

    def done(q: Array, v: Array, t: float, h: float, n: int) -> tuple[Array, Array, Array]:
        here = run.problem.moved(q, v, t)
        begin = Checkpoint(0, *engine.start(here, run.method), end.solver, end.tolerance, n)
        steps = Run(here, run.method, h, n, replace(begin, curves=False))
        there = uninterrupted(run_steps(engine, steps, watched=False))
        return there.q[-1], there.p[-1], there.v[-1]

    def reach(q: Array, v: Array, t: float, time: float) -> tuple[Array, Array, Array]:
        whole = int((time - t) / step)
        rest = time - (t + whole * step)
        if whole:
            q, p, v = done(q, v, t, step, whole)
            if rest == 0.0 or not np.all(np.isfinite(q)):  # or a step failed
                return q, p, v
        return done(q, v, t + whole * step, rest, 1)

    return reach
