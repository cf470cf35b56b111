"""Converts an engine's states to a Trajectory, with non-finite states turned into a failure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from galvi import End, NBody, Outcome, Problem, Trajectory
from galvi.arrays import Array, read_only
from galvi.systems.lagrangian import momentum_at
from galvi.trajectory import Ending


@dataclass(frozen=True)
class Failure:
    """An early end of a run.

    Attributes
    ----------
    row
        index of the first saved state that was not computed; it and the later states become NaN
    step
        number of the first step not done, counted from 1; of a code that chooses its steps, of the
        first saved state not reached
    why
        the reason and the remedy, in a sentence
    """

    row: int
    step: int
    why: str


def non_finite(
    step: int, saved: Array, times: Array, reason: str = "the step is too large"
) -> Failure:
    """The failure of a run of equal steps that gave a non-finite state.

    Parameters
    ----------
    step
        number of the first step with a non-finite state
    saved, times
        numbers of the saved steps and their times, (saved,)
    """
    row = int(np.searchsorted(saved, step))
    return Failure(
        row=row,
        step=step,
        why=f"Step {step}, towards t = {times[row]:.6g}, gave a non-finite state: {reason}. Choose "
        "a smaller step, or end the run earlier.",
    )


def as_trajectory(
    problem: Problem,
    method: str,
    t: Array,
    q: Array,
    v: Array | None = None,
    *,
    p: Array | None = None,
    counts: Mapping[str, int],
    step: float | None = None,
    failure: Failure | None = None,
    notes: Iterable[str] = (),
) -> Trajectory:
    """The trajectory of states at times t (saved,).

    Parameters
    ----------
    q, v, p
        configurations, and velocities or momenta; each reshapes to (saved, ...) with the shape of
        the problem's start
    notes
        sentences that are appended to the status of a run without failure; empty ones are ignored

    Notes
    -----
    A non-finite state that the engine did not report becomes a failure.
    """
    q = np.array(q, dtype=np.float64).reshape(len(t), *problem.q0.shape)
    v_or_p = np.array(v if p is None else p, dtype=np.float64).reshape(len(t), *problem.v0.shape)
    p = momentum_at(problem.system, q, v_or_p, t) if p is None else v_or_p
    finite = np.all(np.isfinite(np.hstack([q.reshape(len(t), -1), p.reshape(len(t), -1)])), axis=1)
    if failure is None and not np.all(finite):
        row = int(np.argmin(finite))
        failure = Failure(
            row=row,
            step=row,
            why=f"The state at t = {t[row]:.6g} is not finite: bodies met or the step is too "
            "large. Use smaller steps, or end the run earlier.",
        )
    system, velocities = problem.system, None
    if isinstance(system, NBody) and system.has_massless:
        velocities = v_or_p
    if failure is not None:
        for states in (q, p, v_or_p):
            states[failure.row :] = np.nan
        outcome = Outcome(End.STEP_FAILED, failure.step, sentence=failure.why)
    else:
        outcome = Outcome(End.COMPLETED, notes=tuple(filter(None, notes)))
    return Trajectory(
        problem=problem,
        t=read_only(t),
        q=read_only(q),
        p=read_only(p),
        counts=dict(counts),
        step=step,
        method=method,
        ending=Ending(outcome),
        velocities=None if velocities is None else read_only(velocities),
    )
