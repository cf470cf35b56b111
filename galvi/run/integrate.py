"""Integrates a problem with a method."""

from __future__ import annotations

from collections.abc import Callable, Sized
from functools import partial
from typing import Any

from galvi import input_checks
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.engines import stepper_for
from galvi.run.loop import run_steps
from galvi.run.request import RunRequest, announce, check_memory
from galvi.trajectory import Trajectory


def integrate(
    problem: Problem,
    method: Galerkin,
    step: float,
    steps: int | None = None,
    *,
    duration: float | None = None,
    events: Any = (),
    save_every: int = 1,
    curves: bool | None = None,
    solver: str = "auto",
    tolerance: float | None = None,
    progress: bool | None = None,
) -> Trajectory:
    """Integrate ``problem`` with ``method``.

    Parameters
    ----------
    problem
        a `Problem`: a system with its initial state and time
    method
        a `Galerkin`
    step
        step size h in the problem's unit of time, or with a clock in the clock's unit; a negative
        one integrates backwards
    steps
        number of steps; give either this or ``duration``. With a clock, the largest number of steps
        where ``duration`` is given too
    duration
        length of time, positive and a whole number of steps. With a clock it may have any length: a
        shortened last step reaches its end
    events
        `galvi.Event` values, one, several or none; their occurrences are in ``run.events``, and
        they may end the run or change its state
    save_every
        k keeps the states after 0, k, 2 k, ... steps and the last
    curves
        whether to keep every step's Galerkin curve; None: only when save_every is 1
    solver
        "auto", "fixed_point" or "newton"; on groups, and for a Canonical system with a force or a
        degree for each component, "fixed_point" only where functions are built in, from SymPy, or
        could be traced; in a moving frame not "newton"
    tolerance
        change relative to ``|q|`` at which a step's iteration stops; None: round-off
    progress
        True shows a progress bar

    Returns
    -------
    Trajectory
        The run, also when a step fails (see ``success`` and ``status``) or Ctrl-C stops it. A run
        whose energy, less the work of its forces, is ruined goes on to its end and keeps its
        states, but is no success. The status of a success names a doubtful energy, a velocity under
        fast damping, three hinges near gimbal lock, an unresolved passage of two point masses, a
        doubtful motion of a massless body, and a user function that raises where the energy is
        evaluated.

    Raises
    ------
    ValueError, TypeError
        For bad input, before the first step; exceptions of user functions in a step pass through.
    KeyboardInterrupt
        For Ctrl-C after the last step or after a step that failed; its attribute ``run`` is the
        trajectory.

    Examples
    --------
    >>> problem = galvi.problems.kepler(eccentricity=0.6)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(problem, method, step=0.25, steps=100)
    >>> run.status, run.q.shape, run(0.1).shape
    ('Completed.', (101, 2), (2,))
    """
    request = RunRequest.checked(
        problem, method, step, steps, duration=duration, save_every=save_every, curves=curves,
        solver=solver, tolerance=tolerance,
    )  # fmt: skip
    check_memory([request])
    return prepare_run(request, events)(progress=progress)


def prepare_run(request: RunRequest, events: Any = ()) -> Callable[..., Trajectory]:
    """A function of the keywords ``progress`` and ``interrupted`` that does the run, by the first
    engine that offers a stepper; ValueError where none does, TypeError for a value in ``events``
    that is no `galvi.Event`."""
    if has_events(events):
        from galvi.events.run import with_events  # galvi.events imports this module

        return with_events(request, events)
    stepper = stepper_for(request)
    if request.checkpoint.solver != "newton" and request.method.clock is None:
        announce(request.problem)
    return partial(run_steps, stepper)


def has_events(events: Any) -> bool:
    """False for None and for an empty list or array; else True."""
    if isinstance(events, Sized) and input_checks.has_items(events):
        return len(events) > 0
    return events is not None
