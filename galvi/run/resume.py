"""Continues a run from its end."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.checkpoint import Checkpoint
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.run.integrate import has_events, prepare_run
from galvi.run.request import (
    RunRequest,
    check_memory,
    from_start,
    number_of_steps,
    steps_until,
    time_after,
    trace_anew,
)
from galvi.systems.multibody import Multibody
from galvi.trajectory import Trajectory


def resume(
    run: Trajectory,
    steps: int | None = None,
    *,
    duration: float | None = None,
    until: float | None = None,
    events: Any = None,
    save_every: int | None = None,
    curves: bool | None = None,
    progress: bool | None = None,
    ctrl: Any = None,
) -> Trajectory:
    """Continue a run from its end, with its step, method, solver and tolerance.

    Parameters
    ----------
    run
        the run to continue
    steps, duration, progress
        as for `galvi.integrate`
    until
        the time at which to end, a whole number of steps from the problem's start; instead of steps
        or duration
    events
        as for `galvi.integrate`; None: those of ``run``, () for none
    save_every, curves
        as for `galvi.integrate`; None: as in ``run``
    ctrl : array, shape (nu,)
        other controls of a MuJoCo model's actuators, constant over the given steps or duration. The
        new run does not continue ``run``: its ``problem`` has these controls and starts at the end
        of ``run``, from where its energy is assessed

    Returns
    -------
    Trajectory
        The new part of the run, as `galvi.integrate` returns one; its first state is the last of
        ``run``.

    Raises
    ------
    ValueError
        For a run that failed, for a run of a reference, and for bad input.

    Notes
    -----
    Without ``ctrl`` the states are bit-identical to the same part of one long run, also where
    Ctrl-C ended ``run``, or an event ended it within a step: the steps go on from the last grid
    point. After an action the ``problem`` is that which the action left. The energy is assessed
    together with all steps before, so that a run continued after it was ruined is ruined from its
    first step on.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> first = galvi.integrate(problem, method, step=0.25, steps=40)
    >>> rest = galvi.resume(first, steps=60)
    >>> whole = galvi.integrate(problem, method, step=0.25, steps=100)
    >>> np.array_equal(rest.q[-1], whole.q[-1])
    True
    """
    _check_resumed(run)
    if events is None and run.events is not None and not run.asked:
        raise ValueError(
            "a run from a file has no functions of events. Give its events again, or events=() to "
            "go on without."
        )
    if ctrl is not None:
        return _with_controls(
            run, ctrl, steps, duration, until, events, save_every, curves, progress
        )
    problem, method, step = run.origin or run.problem, run.method, cast(float, run.step)
    start = cast(Checkpoint, run.checkpoint)
    wanted_events = run.asked if events is None else events
    if save_every is not None:
        start = replace(start, save_every=input_checks.whole("save_every", save_every))
    if curves is not None:
        start = replace(start, curves=input_checks.flag("curves", curves))
    trace_anew(problem)
    if method.clock is not None:
        return _resumed_in_clock(
            run, problem, start, steps, duration, until, wanted_events, progress
        )
    if until is None:
        total = number_of_steps(step, steps, duration)
    elif steps is None and duration is None:
        total = steps_until(until, problem.t0, step, start.first)
    else:
        raise ValueError("give one of steps, duration and until; received until and another.")
    request = RunRequest(problem, method, step, total, start, continues=run)
    check_memory([request])
    return prepare_run(request, wanted_events)(progress=progress)


def _continuation(run: Trajectory) -> Checkpoint | None:
    """A checkpoint with the settings of a run's continuation; it does not assess the run."""
    return run.ending.settings


def _check_resumed(run: Any) -> None:
    """ValueError unless ``run`` can be continued."""
    is_run = isinstance(run, Trajectory) and run.step is not None
    if not is_run or _continuation(run) is None:
        raise ValueError(
            f"only a run of galvi.integrate with its problem can be resumed; received {shown(run)}."
        )
    if not np.all(np.isfinite(run.q[-1])) and not run.interrupted and not run.success:
        raise ValueError(f"a run that failed cannot be resumed; its status: {run.status}")


def _with_controls(
    run: Trajectory,
    ctrl: Any,
    steps: int | None,
    duration: float | None,
    until: float | None,
    events: Any,
    save_every: int | None,
    curves: bool | None,
    progress: bool | None,
) -> Trajectory:
    """`resume` with other controls: a new run from the last state, with the compiled kernels."""
    problem, method, step = run.origin or run.problem, run.method, cast(float, run.step)
    if not isinstance(problem.system, Multibody):
        raise ValueError(
            f"ctrl is of the actuators of a MuJoCo model, a galvi.Multibody; received it for a "
            f"{type(problem.system).__name__}."
        )
    if method.clock is not None or has_events(run.asked if events is None else events):
        raise ValueError(
            "ctrl needs equal steps without events; received a run with a clock or events. Make a "
            "problem of its end, with system.with_numbers(ctrl=...)."
        )
    if until is not None:
        raise ValueError("with ctrl give steps or duration; received until.")
    start = cast(Checkpoint, _continuation(run))
    system = problem.system.with_numbers(ctrl=ctrl)
    if beyond := system.beyond_limits(run.q[-1], run.v[-1], 0.0):
        raise ValueError(f"{beyond} at the run's end. Choose other controls.")
    moved = problem.moved(run.q[-1], run.v[-1], float(run.t[-1]), system)
    vars(moved)["p0"] = run.p[-1]
    begin = from_start(
        start.solver,
        start.tolerance,
        start.save_every if save_every is None else input_checks.whole("save_every", save_every),
        start.curves if curves is None else input_checks.flag("curves", curves),
    )
    request = RunRequest(moved, method, step, number_of_steps(step, steps, duration), begin)
    check_memory([request])
    return prepare_run(request)(progress=progress)


def _resumed_in_clock(
    run: Trajectory,
    problem: Problem,
    start: Checkpoint,
    steps: int | None,
    duration: float | None,
    until: float | None,
    events: Any,
    progress: bool | None,
) -> Trajectory:
    """`resume` with a clock: from the last grid point, which a shortened last step did not move."""
    assert run.step is not None
    h, t = run.step, float(run.t[-1])
    if until is not None and duration is not None:
        raise ValueError("give one of duration and until; received both.")
    if steps is None and duration is None and until is None:
        raise ValueError("give steps, duration or until; received none.")
    most_steps = None if steps is None else input_checks.whole("steps", steps)
    time = None
    if duration is not None:
        time = time_after(t, duration, h)
    if until is not None:
        time = input_checks.real("until", until)
        if not (time - t) * h > 0.0:
            raise ValueError(
                f"until must be after t = {t!r}, where the run ends; received {until!r}."
            )
    request = RunRequest(problem, run.method, h, most_steps, start, time, run)
    return prepare_run(request, events)(progress=progress)
