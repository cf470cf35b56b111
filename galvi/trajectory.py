"""The result of a run: times, states, status, counts and curves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves, RedoneClockCurves
from galvi.curves.curves import Curves, FrameCurves, RedoneCurves
from galvi.problem import Problem
from galvi.systems.lagrangian import velocity_at

if TYPE_CHECKING:
    import pandas

COMPLETED = "Completed."
JUDGED = ("success", "status", "failed_step", "checkpoint")
ONE_AT_A_TIME = threading.RLock()


class Restarts(NamedTuple):
    """States (n, ...) to which actions changed a run, at times (n,)."""

    t: Array
    q: Array
    v: Array


class Later:
    """The value of a field that is found when it is first read."""

    def __repr__(self) -> str:
        return "found when it is read"


LATER: Any = Later()


class FoundLater:
    """A field of a trajectory that may have the value `LATER`."""

    def __init__(self, name: str, default: Any) -> None:
        self._name, self._default = name, default

    def __get__(self, run: Trajectory | None, owner: type) -> Any:
        if run is None:
            return self._default
        if vars(run)[self._name] is LATER:
            run._judge()
        return vars(run)[self._name]

    def __set__(self, run: Trajectory, value: Any) -> None:
        vars(run)[self._name] = value


@dataclass(frozen=True, eq=False)
class Trajectory:
    """States of one problem at increasing (or, for a negative step, decreasing) times.

    success, status, failed_step and checkpoint of a run of `galvi.integrate` are found when one of
    them is first read, by the energies of a part of its steps.

    problem       the problem integrated
    t             (saved,) times
    q, p          (saved, ...) configurations and conjugate momenta; NaN after a step that failed
    success       whether all steps were completed and the energy, less the work of forces, was not
                  ruined: changed by more than the larger of the kinetic energy at the start and the
                  range of the potential energy while the error was below 1 % of that
    status        a sentence saying why the run ended. It warns of a success whose energy changed
                  by 1 % to 100 % of that measure, of a velocity that is damped in a small part of
                  a step, of gimbal lock, and of two point masses that passed each other too fast
                  for a step, which the energy of all bodies need not show
    failed_step   number, counted from 1, of the first step not completed, or if all are, of the
                  first one seen to be ruined; None on success
    counts        steps, iterations, force_evaluations, hessian_evaluations, linear_solves, and
                  for N bodies pair_evaluations, including those of two-body iterations; and
                  newton_steps, where fixed-point iteration left some of a Lagrangian or a body to
                  Newton's method; potential_evaluations, where derivatives were differenced; in a
                  frame inertial_steps, done in the inertial one
    step          the step size; None for a reference that chooses its own steps
    method        the method or reference that computed it
    curves        the Galerkin curve of each step; None if not kept
    checkpoint    the state from which `galvi.resume` continues; None for references
    interrupted   whether Ctrl-C ended the run, which can then be resumed
    again         finds the curves again where they were not kept; None for references
    engine        what did its steps, or began them: "general", "lanes", "frame", "clock"; "" for
                  references
    engine_reason why that engine did them
    velocities    (saved, ...) those of point masses some of which are massless, whose p is 0 at any
                  velocity; else None. See ``v``
    tau           (saved,) of a run in a clock, k h after k steps; else None. There ``step`` is in
                  units of tau, and the arrays end with the last state computed
    events        the `galvi.Found` of the events that `galvi.integrate` was given; None without
    asked         those events, which `galvi.resume` goes on with
    restarts      the states to which actions changed the run; None without
    origin        the problem from a step's end after the last action, which `galvi.resume`
                  continues; None: ``problem``
    """

    problem: Problem
    t: Array
    q: Array
    p: Array
    success: bool = True
    status: str = COMPLETED
    failed_step: int | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    step: float | None = None
    method: Any = None
    curves: Curves | FrameCurves | ClockCurves | None = None
    checkpoint: Checkpoint | None = None
    interrupted: bool = False
    velocities: Array | None = None
    again: RedoneCurves | RedoneClockCurves | None = None
    engine: str = ""
    tau: Array | None = None
    events: Any = None
    asked: tuple[Any, ...] = ()
    restarts: Restarts | None = None
    origin: Problem | None = None
    engine_reason: str = ""

    def _judge_later(self, find: Callable[[], Mapping[str, Any]], began: Any = None) -> None:
        """Let ``find`` tell how the run ended, once one of these fields is read; it began from a
        state with the settings of its continuation."""
        vars(self).update(dict.fromkeys(JUDGED, LATER), _find=find, _began=began)

    def _judge(self) -> None:
        """Find how the run ended, unless it is known."""
        with ONE_AT_A_TIME:
            find = vars(self).get("_find")
            if find is not None:
                vars(self).update(find())
                vars(self).pop("_find", None)
                vars(self).pop("_began", None)

    def __getstate__(self) -> dict[str, Any]:
        self._judge()
        return dict(vars(self))

    def __call__(self, t: Any) -> Array:
        """Configuration on the curve at t: shape (...) for a scalar, (k, ...) for t of shape (k,).

        NaN after a failure. Where curves were not kept, up to 1024 steps, or a 512th of the run,
        are done again, with the same result to the bit. Raises ValueError when t is outside the run
        and for a run of a reference.
        """
        return self._kept_curves().position(t)

    @property
    def v(self) -> Array:
        """Velocities at the saved times, of p's shape; on a group the body velocities."""
        return self.velocities if self.velocities is not None else self._from_momenta.copy()

    @cached_property
    def _from_momenta(self) -> Array:
        found = velocity_at(self.problem.system, self.q, self.p, self.t, self.problem.v0)
        return read_only(found)

    def velocity(self, t: Any) -> Array:
        """Velocity of the curve at t: dq/dt, or on a group the body velocity; raises as a call."""
        return self._kept_curves().velocity(t)

    def __len__(self) -> int:
        """The number of saved states."""
        return len(self.t)

    def to_rebound(self, at: int = -1) -> Any:
        """A `rebound.Simulation` at a saved state: see galvi.interop.rebound."""
        from galvi.interop.rebound import to_rebound

        return to_rebound(self, at)

    def to_scipy(self) -> Any:
        """The run with the fields of SciPy's solve_ivp: see galvi.interop.exports."""
        from galvi.interop.exports import to_scipy

        return to_scipy(self)

    def to_xarray(self) -> Any:
        """An xarray.Dataset with named dimensions: see galvi.interop.exports."""
        from galvi.interop.exports import to_xarray

        return to_xarray(self)

    def plot(self) -> Any:
        """A matplotlib figure of the motion and the energy: see galvi.interop.exports."""
        from galvi.interop.exports import plot

        return plot(self)

    def to_frame(self) -> pandas.DataFrame:
        """A tidy pandas frame: t (and tau), then a column for each component of q and of p."""
        import pandas

        def columns(name: str, states: Array) -> dict[str, Array]:
            flat = states.reshape(len(states), -1)
            labels = [",".join(map(str, index)) for index in np.ndindex(states.shape[1:])]
            return {f"{name}[{label}]": flat[:, k] for k, label in enumerate(labels)}

        tau = {} if self.tau is None else {"tau": self.tau}
        return pandas.DataFrame(
            {"t": self.t, **tau, **columns("q", self.q), **columns("p", self.p)}
        )

    def _kept_curves(self) -> Any:
        curves = self.curves if self.curves is not None else self.again
        if curves is None:
            raise ValueError(
                "this run has no curves to evaluate: they are those of galvi.integrate, not of a "
                "reference, and with actions only those that it keeps, with curves=True."
            )
        return curves

    def __repr__(self) -> str:
        return (
            f"Trajectory({self.problem.name or 'problem'}, t = {self.t[0]:g} to {self.t[-1]:g}, "
            f"{len(self.t)} states, {self.status})"
        )


for _name in JUDGED:
    setattr(Trajectory, _name, FoundLater(_name, getattr(Trajectory, _name)))
