"""Runs a method on a problem."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sized
from dataclasses import replace
from functools import partial
from typing import Any, cast
from weakref import WeakKeyDictionary, WeakSet

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem, WithFunctions
from galvi.run.clocked.run import check_step, run_in_clock
from galvi.run.engine_choice import engine_for
from galvi.run.loop import run_steps
from galvi.run.nystrom_engine import ROUND_OFF, SOLVERS
from galvi.run.plan import Engine, Run, check_memory, number_of_steps, steps_until
from galvi.systems.canonical import Canonical
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.system import VectorSystem
from galvi.systems.traces import Traces, traces
from galvi.trajectory import Trajectory

LOG = logging.getLogger("galvi")
_TRACED: WeakKeyDictionary[Problem, Traces] = WeakKeyDictionary()  # with which p0 was computed
_ANNOUNCED: WeakSet[WithFunctions | NBody] = WeakSet()
_CHECKED: WeakSet[Problem] = WeakSet()  # problems whose functions have been checked at the start


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

    step        step size h in the problem's unit of time; negative integrates backwards. With a
                clock, in its units
    steps       number of steps; or
    duration    length of time, positive and a whole number of steps. With a clock of any length,
                reached by a last step that is shortened, and ``steps`` is the most there may be
    events      `galvi.Event` values, one, several or none, which are found in ``run.events``, may
                end the run or change its state
    save_every  k keeps steps 0, k, 2 k, ... and the last
    curves      keep every step's Galerkin curve; None: only when save_every is 1
    solver      "auto", "fixed_point" or "newton"; on groups, and for a Canonical system with a
                force or a degree for each component, "fixed_point" only where functions are built
                in, from SymPy, or could be traced; in a moving frame not "newton"
    tolerance   change relative to |q| at which a step's iteration stops; None: round-off
    progress    True shows a progress bar

    Returns a Trajectory, also when a step fails (see ``success`` and ``status``) or Ctrl-C stops
    the run. A run whose energy, less the work of its forces, is ruined goes on to its end and keeps
    its states, but is no success. A success has a status that says so where the energy, a velocity
    under fast damping, a passage of two point masses or the motion of a body without mass is in
    doubt, or where the energy is not known since a user's function raises. Raises
    ValueError or TypeError for bad input before the first step; exceptions of user functions in a
    step pass through. Ctrl-C after the last step, or one that failed, raises KeyboardInterrupt,
    whose attribute ``run`` is the trajectory.
    """
    if isinstance(method, Galerkin) and method.clock is not None:
        run_it = checked_in_clock(
            problem, method, step, steps, duration=duration, save_every=save_every, curves=curves,
            solver=solver, tolerance=tolerance,
        )  # fmt: skip
        if has_events(events):
            return with_events(*run_it.args, events)(progress=progress)
        return run_it(progress=progress)
    engine, run = checked(
        problem, method, step, steps, duration=duration, save_every=save_every, curves=curves,
        solver=solver, tolerance=tolerance,
    )  # fmt: skip
    check_memory([run])
    if has_events(events):
        given = problem, method, run.step, run.start, run.steps, None, events
        return with_events(*given)(progress=progress)
    return run_steps(engine, run, progress=progress)


def with_events(*run: Any) -> Callable[..., Trajectory]:
    """See `galvi.events.run.with_events`, which searches runs and stands above them."""
    from galvi.events.run import with_events

    return with_events(*run)


def has_events(events: Any) -> bool:
    """Whether there are any: not in an empty list or array, nor in None."""
    if isinstance(events, Sized) and input_checks.has_items(events):
        return len(events) > 0
    return events is not None


def check_types(problem: object, method: object, call: str) -> None:
    """TypeError unless they are a problem and a method; ``call`` shows how."""
    for name, value, kind in (("problem", problem, Problem), ("method", method, Galerkin)):
        if not isinstance(value, kind):
            raise TypeError(
                f"{name} must be a galvi.{kind.__name__}; received {shown(value)}. "
                f"Call galvi.{call}."
            )


def checked(
    problem: Problem, method: Galerkin, step: float, steps: int | None = None, *,
    duration: float | None = None, save_every: int = 1, curves: bool | None = None,
    solver: str = "auto", tolerance: float | None = None,
) -> tuple[Engine, Run]:  # fmt: skip
    """The run of `integrate`, its arguments checked, except that the result fits in memory: see
    `check_memory`; and the engine that does it."""
    h, solver, tol, save_every, curves = _settings(
        problem, method, step, solver, tolerance, save_every, curves
    )
    total = number_of_steps(h, steps, duration)
    check_end(problem.t0, h, total)
    if problem.t0 + h == problem.t0:
        raise ValueError(
            f"step must change the time; received {step!r} at t0 = {problem.t0!r}, where times are "
            f"{math.ulp(problem.t0):.1e} apart. Shift t0 towards 0, or use a larger step."
        )
    _trace_anew(problem)
    engine = engine_for(problem, method)
    if solver not in engine.solvers:
        raise ValueError(
            f"in a moving frame the solver must be one of {', '.join(engine.solvers)}; received "
            f"{solver!r}."
        )
    if solver == "fixed_point":
        _check_iteration(engine, problem, method)
    _check_functions(problem)
    if solver != "newton" and isinstance(problem.system, WithFunctions | NBody):
        _announce(problem, problem.system)
    begin = engine.start(problem, method)
    start = Checkpoint(0, *begin, solver, tol, save_every, curves)
    return engine, Run(problem, method, h, total, start)


def _settings(
    problem: Problem, method: Galerkin, step: float, solver: str, tolerance: float | None,
    save_every: int, curves: bool | None,
) -> tuple[float, str, float, int, bool | None]:  # fmt: skip
    """The settings of `integrate`, checked: step, solver, tolerance, save_every and curves."""
    check_types(problem, method, "integrate(problem, method, step, steps), or give a duration")
    h = input_checks.real(
        "step", step, "The length of a run is given by steps or duration, its begin by problem.t0."
    )
    if h == 0.0:
        raise ValueError("step must not be zero; received 0. Give the step size in units of time.")
    if not isinstance(solver, str) or solver not in SOLVERS:
        raise ValueError(f"solver must be one of {', '.join(SOLVERS)}; received {shown(solver)}.")
    save_every = input_checks.whole("save_every", save_every)
    tol = ROUND_OFF if tolerance is None else input_checks.positive("tolerance", tolerance)
    return (
        h,
        solver,
        tol,
        save_every,
        None if curves is None else input_checks.flag("curves", curves),
    )


def checked_in_clock(
    problem: Problem, method: Galerkin, step: float, steps: int | None = None, *,
    duration: float | None = None, save_every: int = 1, curves: bool | None = None,
    solver: str = "auto", tolerance: float | None = None,
) -> partial[Trajectory]:  # fmt: skip
    """The run of `integrate` with a clock, its arguments checked."""
    h, solver, tol, save_every, curves = _settings(
        problem, method, step, solver, tolerance, save_every, curves
    )
    if steps is None and duration is None:
        raise ValueError("give steps, or a duration, or both; received neither.")
    _trace_anew(problem)
    _check_functions(problem)
    most = None if steps is None else input_checks.whole("steps", steps)
    time = None
    if duration is not None:
        length = input_checks.positive("duration", duration, "For backwards, make step negative.")
        time = _time_after(problem.t0, length, h)
    check_step(problem, method, h)
    nothing = np.zeros((0, 0))
    start = Checkpoint(0, nothing, nothing, np.zeros(0, np.int64), solver, tol, save_every, curves)
    if most is not None and time is None:
        check_memory([Run(problem, method, h, most, start)])
    return partial(run_in_clock, problem, method, h, start, most, time)


def _time_after(t: float, length: float, step: float) -> float:
    """The time ``length`` after t, before it for a negative step; ValueError where that is t."""
    time = t + math.copysign(length, step)
    if time == t or not math.isfinite(time):
        raise ValueError(
            f"duration must change the time; received {length!r} at t = {t!r}. Shift t0 towards 0."
        )
    return time


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

    until               the time at which to end, a whole number of steps from the problem's start;
                        instead of steps or duration
    events              as for `galvi.integrate`; None: those of ``run``, () for none
    save_every, curves  as for `galvi.integrate`; None: as in ``run``
    ctrl                (nu,) other controls of a MuJoCo model's actuators, held from here on, for
                        steps or a duration: the result is a run of its own, whose ``problem`` has
                        them and starts here, and whose energy is judged from here on
    others              as for `galvi.integrate`

    Without ``ctrl`` the result starts where ``run`` ended, also when Ctrl-C ended it, and its
    states are bit-identical to the same part of one long run, also where an event ended ``run``
    within a step: it goes on from the grid. After an action its ``problem`` is that which the
    action left. Its energy is judged with that of all steps before it, so that a run continued
    after it was ruined
    is ruined from its first step on. Raises ValueError for a run that stopped, for a run of a
    reference, and for bad input.
    """
    _check_resumed(run)
    if events is None and run.events is not None and not run.asked:
        raise ValueError(
            "a run from a file has no functions of events. Give its events again, or events=() to "
            "go on without."
        )
    if ctrl is not None:
        return _with_controls(run, ctrl, steps, duration, until, events, save_every, curves,
                              progress)  # fmt: skip
    problem, method, step = run.origin or run.problem, run.method, cast(float, run.step)
    start = cast(Checkpoint, run.checkpoint)
    asked = run.asked if events is None else events
    if save_every is not None:
        start = replace(start, save_every=input_checks.whole("save_every", save_every))
    if curves is not None:
        start = replace(start, curves=input_checks.flag("curves", curves))
    _trace_anew(problem)
    if method.clock is not None:
        return _resumed_in_clock(run, problem, start, steps, duration, until, asked, progress)
    if until is None:
        total = number_of_steps(step, steps, duration)
    elif steps is None and duration is None:
        total = steps_until(until, problem.t0, step, start.first)
    else:
        raise ValueError("give one of steps, duration and until; received until and another.")
    more, engine = Run(problem, method, step, total, start), engine_for(problem, method)
    if start.solver == "fixed_point":
        _check_iteration(engine, problem, method)
    check_memory([more])
    if has_events(asked):
        return with_events(problem, method, step, start, total, None, asked, run)(progress=progress)
    return run_steps(engine, more, progress=progress)


def _continuation(run: Trajectory) -> Checkpoint | None:
    """A state of a run with the settings of its continuation, without judging the run."""
    return run.ending.settings


def _check_resumed(run: Any) -> None:
    """ValueError for what is no run to be continued."""
    is_run = isinstance(run, Trajectory) and run.step is not None
    if not is_run or _continuation(run) is None:
        raise ValueError(
            f"only a run of galvi.integrate with its problem can be resumed; received {shown(run)}."
        )
    if not np.all(np.isfinite(run.q[-1])) and not run.interrupted and not run.success:
        raise ValueError(f"a run that failed cannot be resumed; its status: {run.status}")


def _with_controls(
    run: Trajectory, ctrl: Any, steps: int | None, duration: float | None, until: float | None,
    events: Any, save_every: int | None, curves: bool | None, progress: bool | None,
) -> Trajectory:  # fmt: skip
    """`resume` with other controls: a run of its own from that state, with what is compiled."""
    problem, method, step = run.origin or run.problem, run.method, cast(float, run.step)
    if not isinstance(problem.system, Multibody):
        raise ValueError(
            f"ctrl is of the actuators of a MuJoCo model that galvi.integrate runs; received it "
            f"for a {type(problem.system).__name__}."
        )
    if method.clock is not None or has_events(run.asked if events is None else events):
        raise ValueError(
            "ctrl is for equal steps without events; received a run with a clock or events. Make a "
            "problem of its end, with system.with_numbers(ctrl=...)."
        )
    if until is not None:
        raise ValueError("with ctrl give steps or duration; received until.")
    start = cast(Checkpoint, _continuation(run))
    system = problem.system.with_numbers(ctrl=ctrl)
    if beyond := system.beyond_limits(run.q[-1], run.v[-1], 0.0):
        raise ValueError(f"{beyond} at the run's end. Choose other controls.")
    here = problem.moved(run.q[-1], run.v[-1], float(run.t[-1]), system)
    vars(here)["p0"] = run.p[-1]
    total, engine = number_of_steps(step, steps, duration), engine_for(here, method)
    begin = Checkpoint(
        0, *engine.start(here, method), start.solver, start.tolerance,
        start.save_every if save_every is None else input_checks.whole("save_every", save_every),
        start.curves if curves is None else input_checks.flag("curves", curves),
    )  # fmt: skip
    more = Run(here, method, step, total, begin)
    check_memory([more])
    return run_steps(engine, more, progress=progress)


def _resumed_in_clock(
    run: Trajectory, problem: Problem, start: Checkpoint, steps: int | None,
    duration: float | None, until: float | None, asked: Any, progress: bool | None,
) -> Trajectory:  # fmt: skip
    """`resume` with a clock: from the last grid point, which the last shortened step left alone."""
    assert run.step is not None
    h, t = run.step, float(run.t[-1])
    if until is not None and duration is not None:
        raise ValueError("give one of duration and until; received both.")
    if steps is None and duration is None and until is None:
        raise ValueError("give steps, duration or until; received none.")
    most = None if steps is None else input_checks.whole("steps", steps)
    time = None
    if duration is not None:
        time = _time_after(t, input_checks.positive("duration", duration), h)
    if until is not None:
        time = input_checks.real("until", until)
        if not (time - t) * h > 0.0:
            raise ValueError(
                f"until must be after t = {t!r}, where the run ends; received {until!r}."
            )
    if has_events(asked):
        return with_events(problem, run.method, h, start, most, time, asked, run)(progress=progress)
    return run_in_clock(problem, run.method, h, start, most, time, first=run, progress=progress)


def _check_iteration(engine: Engine, problem: Problem, method: Galerkin) -> None:
    """ValueError where only Newton's method can solve the steps."""
    if not engine.solves_by_iteration(problem, method):
        raise ValueError(
            f"with a group, an external force or a degree for each component, the solver "
            f"fixed_point needs galvi.fast, and functions that are built in (EIH for at most 11 "
            f"bodies), from SymPy, or could be traced; received {shown(problem)} with {method.name}"
            f"{_because(problem)}. Use the solver auto."
        )


def check_end(t0: float, step: float, steps: int) -> None:
    """ValueError when the time after ``steps`` steps is too large for a number."""
    if not math.isfinite(t0 + steps * step):
        raise ValueError(
            f"a run must end at a finite time; received {steps} steps of {step!r} from "
            f"t0 = {t0!r}. Use a smaller step."
        )


def _trace_anew(problem: Problem) -> None:
    """Trace functions that refer to numbers which changed since the last time."""
    system = problem.system
    if not isinstance(system, WithFunctions | NBody):
        return
    system.trace(problem.q0, problem.v0, problem.t0, anew=True)
    if _TRACED.get(problem) is not traces(system):
        _TRACED[problem] = traces(system)
        vars(problem).pop("p0", None)


def _announce(problem: Problem, system: WithFunctions | NBody) -> None:
    """Log once, as a warning of logger ``galvi``, that a system runs without a law.

    Not that of a compiled gradient without an external force: it takes few microseconds a step.
    """
    if traces(system).refused and system not in _ANNOUNCED:
        _ANNOUNCED.add(system)
        canonical = isinstance(system, Canonical) and system.force is None
        if canonical and cast(Canonical, system).force_kernel(problem.q0.size).compiled:
            return
        LOG.warning(
            "galvi calls the functions of this system one state at a time, which is slower: not "
            "all could be traced; %s.",
            system.untraced,
        )


def _because(problem: Problem) -> str:
    """Why its functions could not be traced, as a part of a sentence; "" where they could."""
    reason = getattr(problem.system, "untraced", "")
    return f" ({reason})" if reason else ""


def _check_functions(problem: Problem) -> None:
    """Check the user's functions at the start, once for each problem, since it is immutable."""
    if problem in _CHECKED:
        return
    system = problem.system
    with np.errstate(all="ignore"):
        if isinstance(system, WithFunctions):
            system.check_functions(problem.q0, problem.v0, problem.t0)
        if isinstance(system, NBody):
            _check_force(system.acceleration(problem.q0, problem.t0, problem.v0))
        elif not hasattr(system, "group"):
            _check_force(cast(VectorSystem, system).acceleration(problem.q0, problem.t0))
    _CHECKED.add(problem)


def _check_force(force: Array) -> None:
    if not np.all(np.isfinite(force)):
        raise ValueError(
            f"the force must be finite at the start; received {force.tolist()} at q0. Check the "
            f"gradient, or move q0 away from a singularity."
        )
