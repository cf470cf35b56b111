"""The request for a run: a value with checked arguments."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, cast
from weakref import WeakKeyDictionary, WeakSet

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import NOTHING, Checkpoint
from galvi.clocks.clock import check_step
from galvi.input_checks import shown
from galvi.method import Galerkin
from galvi.problem import Problem, WithFunctions
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.system import VectorSystem
from galvi.systems.traces import Traces, traces
from galvi.trajectory import Trajectory

LOG = logging.getLogger("galvi")
# Far below the rounding unit 2^-53: the error left by an iteration is not random and makes the
# energy drift. 32 runs of the outer solar system over 1e6 years (benchmarks/studies/round_off.py,
# degree 8): 23 standard errors of drift with 2^-60, 1.6 with 2^-64, for 3 % more time.
ROUND_OFF = 2.0**-64
SOLVERS = ("auto", "fixed_point", "newton")
NO_ROWS = read_only(np.zeros((0, 0)))
NO_STATE: tuple[Array, Array, Any] = NO_ROWS, NO_ROWS, read_only(np.zeros(0, dtype=np.int64))
ALWAYS_FREE = 2.0**28  # bytes, up to which a run is not compared with the free memory
LARGEST_SLACK = 0.25  # steps by which a time may differ from a whole number of steps
_TRACED: WeakKeyDictionary[Problem, Traces] = WeakKeyDictionary()  # the traces when p0 was computed
_ANNOUNCED: WeakSet[WithFunctions | NBody] = WeakSet()  # systems of which a warning was logged
_CHECKED: WeakSet[Problem] = WeakSet()  # problems whose functions have been checked at the start


class RunRequest(NamedTuple):
    """The problem, method, steps and start of a run.

    Attributes
    ----------
    problem, method, step
        see `galvi.integrate`
    steps
        number of steps; in a clock the largest number, None without a bound
    checkpoint
        the state from which the run begins, and its settings; the problem's start where the state
        has no entries, see `from_start`
    until
        the time at which a run in a clock ends; None: it ends after ``steps``
    continues
        the run that ends at the checkpoint: in a clock and with events its last saved state is the
        first of this one
    """

    problem: Problem
    method: Galerkin
    step: float
    steps: int | None
    checkpoint: Checkpoint
    until: float | None = None
    continues: Trajectory | None = None

    @classmethod
    def checked(
        cls,
        problem: Problem,
        method: Galerkin,
        step: float,
        steps: int | None = None,
        *,
        duration: float | None = None,
        save_every: int = 1,
        curves: bool | None = None,
        solver: str = "auto",
        tolerance: float | None = None,
    ) -> RunRequest:
        """The request of a call of `galvi.integrate` with these arguments.

        Raises
        ------
        ValueError, TypeError
            For bad arguments. Refusals of the engines (`galvi.run.engines`) and the memory
            (`check_memory`) are not checked here.
        """
        check_types(problem, method, "integrate(problem, method, step, steps), or give a duration")
        h = input_checks.real(
            "step",
            step,
            "The length of a run is given by steps or duration, its begin by problem.t0.",
        )
        if h == 0.0:
            raise ValueError(
                "step must not be zero; received 0. Give the step size in units of time."
            )
        if not isinstance(solver, str) or solver not in SOLVERS:
            raise ValueError(
                f"solver must be one of {', '.join(SOLVERS)}; received {shown(solver)}."
            )
        start = from_start(
            solver,
            ROUND_OFF if tolerance is None else input_checks.positive("tolerance", tolerance),
            input_checks.whole("save_every", save_every),
            None if curves is None else input_checks.flag("curves", curves),
        )
        until = None
        if method.clock is None:
            steps = number_of_steps(h, steps, duration)
            check_end(problem.t0, h, steps)
            check_time_changes(problem.t0, h, step)
        elif steps is None and duration is None:
            raise ValueError("give steps, or a duration, or both; received neither.")
        else:
            steps = None if steps is None else input_checks.whole("steps", steps)
            if duration is not None:
                until = time_after(problem.t0, duration, h)
        trace_anew(problem)
        check_functions(problem)
        if method.clock is not None:
            check_step(problem, method.clock, h)
        return cls(problem, method, h, steps, start, until)

    @property
    def begin_time(self) -> float:
        """The time of the first state of a run of equal steps."""
        return self.problem.t0 + self.checkpoint.first * self.step


def from_start(
    solver: str = "auto",
    tolerance: float = ROUND_OFF,
    save_every: int = 1,
    curves: bool | None = None,
) -> Checkpoint:
    """A problem's start, with the settings of a run, and without the entries of a state."""
    none = NOTHING, NOTHING, NOTHING  # of energies, passages and a clock
    return Checkpoint(0, *NO_STATE, solver, tolerance, save_every, curves, *none)


def check_types(problem: object, method: object, call: str) -> None:
    """TypeError unless the arguments are a `Problem` and a `Galerkin`; its message shows
    ``call``."""
    for name, value, kind in (("problem", problem, Problem), ("method", method, Galerkin)):
        if not isinstance(value, kind):
            raise TypeError(
                f"{name} must be a galvi.{kind.__name__}; received {shown(value)}. "
                f"Call galvi.{call}."
            )


def check_end(t0: float, step: float, steps: int) -> None:
    """ValueError unless the time after ``steps`` steps is finite."""
    if not math.isfinite(t0 + steps * step):
        raise ValueError(
            f"a run must end at a finite time; received {steps} steps of {step!r} from "
            f"t0 = {t0!r}. Use a smaller step."
        )


def check_time_changes(t0: float, step: float, received: object) -> None:
    """ValueError where a step is too short to change the time."""
    if t0 + step == t0:
        raise ValueError(
            f"step must change the time; received {received!r} at t0 = {t0!r}, where times are "
            f"{math.ulp(t0):.1e} apart. Shift t0 towards 0, or use a larger step."
        )


def time_after(t: float, duration: Any, step: float) -> float:
    """The time a duration after t, or before t for a negative step; ValueError where that is t or
    not finite."""
    length = input_checks.positive("duration", duration, "For backwards, make step negative.")
    time = t + math.copysign(length, step)
    if time == t or not math.isfinite(time):
        raise ValueError(
            f"duration must lead to another finite time; received {length!r} at t = {t!r}. Shift "
            f"t0 towards 0."
        )
    return time


def number_of_steps(step: float, steps: int | None, duration: float | None) -> int:
    """``steps``, or the duration over the step; ValueError unless that is a whole number, and
    unless exactly one of the two is given."""
    if (steps is None) == (duration is None):
        raise ValueError(
            "give either steps or duration; received " + ("neither." if steps is None else "both.")
        )
    if steps is not None:
        return input_checks.whole("steps", steps)
    length = input_checks.positive("duration", duration, "For backwards, make the step negative.")
    ratio = length / abs(step)
    if ratio > input_checks.LARGEST_WHOLE:
        input_checks.whole("duration over step", ratio)
    count, sign = round(ratio), math.copysign(1.0, step)
    if count < 1 or abs(ratio - count) > min(1e-9 * count, LARGEST_SLACK):
        raise ValueError(
            f"duration must be a whole number of steps; received {length!r} with step {step!r}, "
            f"{ratio:.6g} steps. Choose step={length / max(1, math.ceil(ratio)) * sign!r}"
            + (f" or {length / math.floor(ratio) * sign!r}." if ratio >= 1.0 else ".")
        )
    return count


def steps_until(until: float, t0: float, step: float, first: int) -> int:
    """The number of steps from the end of step ``first`` to the time ``until``; ValueError unless
    it is a positive whole number."""
    ratio = (input_checks.real("until", until) - t0) / step
    end = round(ratio) if abs(ratio) <= input_checks.LARGEST_WHOLE else 0
    slack = 1e-9 + 4.0 * math.ulp(max(abs(t0), abs(until))) / abs(step)  # rounding of the times
    if end <= first or abs(end - ratio) > min(slack, LARGEST_SLACK):
        raise ValueError(
            f"until must be a whole number of steps after t = {t0 + first * step!r}, where the run "
            f"ends; received {until!r} with step {step!r}. Choose {t0!r} + n * {step!r}."
        )
    return end - first


def check_memory(requests: Sequence[RunRequest]) -> None:
    """ValueError when runs that differ only in their problems would keep more data than fits into
    the free memory; not checked for runs to a time or without a number of steps."""
    _, method, _, steps, start, until, *_ = requests[0]
    if steps is None or until is not None:
        return
    d, m = sum(request.problem.q0.size for request in requests), method.space.dimension - 1
    halves = 2 if method.in_frame else 1  # curves of positions, or of velocities too
    rows = 3 * (steps / start.save_every + 2)
    rows += steps * halves * (1 + m) if start.keeps_curves else 0
    needed = 8.0 * d * rows  # bytes of positions, velocities and momenta, and of curves
    if needed > ALWAYS_FREE and needed > (memory := free_memory()):
        many = f"{len(requests)} runs of " if len(requests) > 1 else ""
        raise ValueError(
            f"{many}{steps} steps would keep {needed / 2**30:.3g} GiB in all, more than the "
            f"{memory / 2**30:.3g} GiB that are free on this machine. Keep fewer states with "
            f"save_every, and curves=False."
        )


def free_memory() -> float:
    """Bytes of memory that processes can still allocate."""
    import psutil  # takes 0.05 s, and runs that keep little data do not need it

    return float(psutil.virtual_memory().available)


def trace_anew(problem: Problem) -> None:
    """Trace a problem's functions again where numbers to which they refer have changed."""
    system = problem.system
    if not isinstance(system, WithFunctions | NBody):
        return
    system.trace(problem.q0, problem.v0, problem.t0, anew=True)
    if _TRACED.get(problem) is not traces(system):
        _TRACED[problem] = traces(system)
        vars(problem).pop("p0", None)


def announce(problem: Problem) -> None:
    """Log a warning of logger ``galvi``, once for each system that could not be traced; none for a
    compiled gradient without an external force, whose calls take microseconds.
    """
    system = problem.system
    if not isinstance(system, WithFunctions | NBody):
        return
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


def check_functions(problem: Problem) -> None:
    """Check the user's functions at the start, once for each problem, since it is immutable."""
    if problem in _CHECKED:
        return
    system = problem.system
    with np.errstate(all="ignore"):
        if isinstance(system, WithFunctions):
            system.check_functions(problem.q0, problem.v0, problem.t0)
        if isinstance(system, NBody):
            _check_acceleration(system.acceleration(problem.q0, problem.t0, problem.v0))
        elif not hasattr(system, "group"):
            _check_acceleration(cast(VectorSystem, system).acceleration(problem.q0, problem.t0))
    _CHECKED.add(problem)


def _check_acceleration(acceleration: Array) -> None:
    if not np.all(np.isfinite(acceleration)):
        raise ValueError(
            f"the acceleration must be finite at the start; received {acceleration.tolist()} at "
            f"q0. Check the gradient, or move q0 away from a singularity."
        )
