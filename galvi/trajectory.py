"""The result of a run: times, states, status, counts and curves."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import Curves, FrameCurves
from galvi.curves.redone_curves import RedoneCurves
from galvi.outcome import End, Outcome
from galvi.problem import Problem
from galvi.systems.lagrangian import velocity_at

if TYPE_CHECKING:
    import pandas

ONE_AT_A_TIME = threading.RLock()


class Restarts(NamedTuple):
    """States (n, ...) to which actions changed a run, at times (n,)."""

    t: Array
    q: Array
    v: Array


class Ending(NamedTuple):
    """How a run ended, and the state from which it continues."""

    outcome: Outcome = Outcome()
    checkpoint: Checkpoint | None = None

    @property
    def settings(self) -> Checkpoint | None:
        """A state with the settings of the run's continuation."""
        return self.checkpoint

    def assess(self) -> Ending:
        """The ending itself; see `DeferredEnding.assess`."""
        return self


class DeferredEnding:
    """The ending of a run, assessed when it is first read: once, by one thread at a time.

    Parameters
    ----------
    settings
        see `Ending`; available without assessing the run
    """

    def __init__(self, assess: Callable[[], Ending], settings: Checkpoint | None) -> None:
        self._assess, self.settings = assess, settings
        self._ending: Ending | None = None

    def assess(self) -> Ending:
        """The ending, assessed by the first call."""
        with ONE_AT_A_TIME:
            if self._ending is None:
                self._ending = self._assess()
                del self._assess  # and the arrays of the run that it holds
            return self._ending

    def __reduce__(self) -> tuple[type[Ending], tuple[Outcome, Checkpoint | None]]:
        outcome, checkpoint = self.assess()
        return Ending, (outcome, checkpoint)


@dataclass(frozen=True, eq=False)
class TrajectoryFields:
    """The fields of a `Trajectory`.

    ``success``, ``status`` and ``failed_step`` of another method's run become its ``ending``.
    """

    problem: Problem
    t: Array
    q: Array
    p: Array
    success: InitVar[bool] = True
    status: InitVar[str] = ""
    failed_step: InitVar[int | None] = None
    counts: Mapping[str, int] = field(default_factory=dict)
    step: float | None = None
    method: Any = None
    curves: Curves | FrameCurves | ClockCurves | None = None
    ending: Ending | DeferredEnding = field(default_factory=Ending)
    interrupted: bool = False
    velocities: Array | None = None
    again: RedoneCurves | None = None
    engine: str = ""
    tau: Array | None = None
    events: Any = None
    asked: tuple[Any, ...] = ()
    restarts: Restarts | None = None
    origin: Problem | None = None
    engine_reason: str = ""

    def __post_init__(self, success: bool, status: str, failed_step: int | None) -> None:
        if (success, status, failed_step) == (True, "", None):
            return
        outcome, checkpoint = self.ending.assess()
        if (success, status, failed_step) != (outcome.success, str(outcome), outcome.failed_step):
            end = End.COMPLETED if success else End.STEP_FAILED
            outcome = Outcome(end, failed_step, sentence=status)
            object.__setattr__(self, "ending", Ending(outcome, checkpoint))


class Trajectory(TrajectoryFields):
    """States of one problem at increasing (or, for a negative step, decreasing) times.

    outcome, success, status, failed_step and checkpoint of a run of `galvi.integrate` are assessed
    when one of them is first read, by the energies of a part of its steps. A trajectory of another
    method that failed is made with ``success=False``, ``status``, a sentence, and ``failed_step``.

    Attributes
    ----------
    problem
        the problem integrated
    t : array, shape (saved,)
        times
    q, p : array, shape (saved, ...)
        configurations and conjugate momenta; NaN after a step that failed
    outcome
        how it ended, a `galvi.Outcome`
    success
        whether all steps were completed and the energy, less the work of forces, was not ruined:
        changed by more than the larger of the kinetic energy at the start and the range of the
        potential energy while the error was below 1 % of that
    status
        the outcome as a sentence. It warns of a success whose energy changed by 1 % to 100 % of
        that measure, of a velocity that is damped in a small part of a step, of gimbal lock, and of
        two point masses that passed each other too fast for a step, which the energy of all bodies
        need not show
    failed_step
        number, counted from 1, of the first step that was not completed, or else of the first
        ruined one; None on success
    counts
        steps, iterations, force_evaluations, hessian_evaluations, linear_solves, and for N bodies
        pair_evaluations, including those of two-body iterations; and newton_steps, where
        fixed-point iteration left some of a Lagrangian or a body to Newton's method;
        potential_evaluations, where derivatives were differenced; in a frame inertial_steps, done
        in the inertial one
    step
        the step size; None for a reference that chooses its own steps
    method
        the method or reference that computed it
    curves
        the Galerkin curve of each step; None if not kept
    checkpoint
        the state from which `galvi.resume` continues; None for references
    ending
        outcome and checkpoint, assessed when they are first read
    interrupted
        whether Ctrl-C ended the run, which can then be resumed
    again
        computes the curves again where they were not kept; None for references
    engine
        the engine that did its steps, or began them: "general", "lanes", "frame" or "clock"; "" for
        references
    engine_reason
        why that engine was chosen
    velocities : array, shape (saved, ...)
        velocities of point masses some of which are massless, whose p is 0 at any velocity; else
        None. See ``v``
    tau : array, shape (saved,)
        with a clock, k h after k steps; else None. With a clock ``step`` is in units of tau, and
        the arrays end with the last computed state
    events
        the `galvi.Found` of the events that `galvi.integrate` was given; None without
    asked
        the given events, with which `galvi.resume` goes on
    restarts
        the states to which actions changed the run; None without
    origin
        the problem from a step's end after the last action, which `galvi.resume` continues; None:
        ``problem``

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.harmonic_oscillator(), method, step=0.5, steps=4)
    >>> run.t, run.counts["steps"], run.engine
    (array([0. , 0.5, 1. , 1.5, 2. ]), 4, 'lanes')
    >>> run(1.25).round(6), run.velocity([0.1, 0.2]).shape
    (array([0.315322]), (2, 1))
    """

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        return self.ending.assess().outcome

    @property
    def success(self) -> bool:
        """See `galvi.Outcome`."""
        return self.outcome.success

    @property
    def status(self) -> str:
        """The outcome as a sentence."""
        return str(self.outcome)

    @property
    def failed_step(self) -> int | None:
        """See `galvi.Outcome`."""
        return self.outcome.failed_step

    @property
    def checkpoint(self) -> Checkpoint | None:
        """The state from which `galvi.resume` continues."""
        return self.ending.assess().checkpoint

    def __call__(self, t: Any) -> Array:
        """Configuration on the curve at t: shape (...) for a scalar, (k, ...) for t of shape (k,).

        NaN after a failure. Where curves were not kept, about 1024 steps, or a 512th of a longer
        run, are repeated around each time, with the same result to the bit.

        Raises
        ------
        ValueError
            When t is outside the run and for a run of a reference.
        """
        return self._kept_curves().position(t)

    @property
    def v(self) -> Array:
        """Velocities at the saved times, of p's shape; on a group the body velocities."""
        return self.velocities if self.velocities is not None else self._from_momenta.copy()

    @cached_property
    def _from_momenta(self) -> Array:
        velocities = velocity_at(self.problem.system, self.q, self.p, self.t, self.problem.v0)
        return read_only(velocities)

    def velocity(self, t: Any) -> Array:
        """Velocity of the curve at t: dq/dt, or on a group the body velocity; raises as a call."""
        return self._kept_curves().velocity(t)

    def __len__(self) -> int:
        """The number of saved states."""
        return len(self.t)

    def to_rebound(self, at: int = -1) -> Any:
        """A ``rebound.Simulation`` at a saved state: see galvi.interop.rebound."""
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
        """A tidy pandas.DataFrame: t (and tau), then a column for each component of q and of p."""
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
