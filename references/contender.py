"""The interface of everything that solves a problem, galvi's methods and references alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import Any, Protocol, runtime_checkable

from galvi import LinearSpring, Problem, Trajectory
from galvi.arrays import Array
from references.setting import FixedSteps, check_keys, fixed_steps, sample_times


class EngineMissing(ModuleNotFoundError):
    """A contender cannot run here because its engine, the package ``name``, is missing."""


@runtime_checkable
class Contender(Protocol):
    """A named way to solve a `galvi.Problem`.

    Fixed-step contenders take {"step": h, "save_every": k, ...}: states at t0 + j h, where the time
    is j h and never the engine's own clock. The others choose their steps and take
    {"samples": n, ...}: states at t0 + j duration / n, j = 0 .. n. Of fixed steps every k-th state
    and the last are saved.
    """

    @property
    def name(self) -> str:
        """Name for titles and tables; unique among the references."""

    @property
    def exact(self) -> bool:
        """Whether its solutions are accurate enough to measure the errors of others."""

    @property
    def missing(self) -> str:
        """One sentence saying why its engine cannot be used here; empty when it can.

        A contender whose engine may be missing also has `engine`, the name of the package.
        """

    def supports(self, problem: Problem) -> bool:
        """Whether it solves this problem, decided by types and fields, never by the name."""

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Solve from t0 to t0 + duration, in the problem's units of time.

        A run that fails returns a trajectory with ``success`` False, the reason as a sentence, and
        NaN past the failure.

        Raises
        ------
        ValueError
            For a problem it does not support, an unknown key in the setting or a value out of
            range.
        EngineMissing
            When the engine is missing.
        """


@runtime_checkable
class Reference(Contender, Protocol):
    """A contender of this package, which also says whether its steps are fixed."""

    @property
    def fixed_step(self) -> bool:
        """Whether its setting has a ``step``; else it has ``samples``, and for most contenders a
        ``tolerance``."""


# Obstacle, as a refusal names it -> the fields of a system that cause it, and the values that
# remove it.
OBSTACLES: Mapping[str, Mapping[str, Any]] = {
    "its external force": {"force": None, "timed_force": False},
    "its gradient, which is not that of its potential": {"gradient": None},
    "its slopes, which replace those of its Lagrangian": {"slopes": None},
    "its potential, of which no formula is known here": {
        "potential": LinearSpring(1.0),
        "gradient": None,
        "hessian": None,
        "explicit_time": False,
    },
}


def refusal_reason(contender: Contender, problem: Problem) -> str:
    """The obstacles without which the contender would take the problem, as text; '' for none."""
    system: Any = problem.system
    fields = {field.name for field in dataclasses.fields(system) if field.init}
    obstructing = {
        obstacle: cleared
        for obstacle, cleared in OBSTACLES.items()
        if cleared.keys() <= fields and getattr(system, next(iter(cleared))) is not None
    }
    for number in range(1, len(obstructing) + 1):
        for obstacles in combinations(obstructing, number):
            cleared = {
                name: value for word in obstacles for name, value in obstructing[word].items()
            }
            plain = dataclasses.replace(problem, system=dataclasses.replace(system, **cleared))
            if contender.supports(plain):
                return " and ".join(obstacles)
    return ""


def refusal(
    name: str,
    contenders: Iterable[Contender],
    problem: Problem,
    remedy: str = "Ask supports(problem) first.",
) -> str:
    """A sentence saying that no contender of a code solves the problem, with the reason if
    known."""
    reason = next(
        filter(None, (refusal_reason(contender, problem) for contender in contenders)), ""
    )
    return (
        f"{name} does not solve this kind of problem; received {problem!r} with a "
        f"{type(problem.system).__name__} system. "
        + (f"The reason is {reason}." if reason else remedy)
    )


def missing_engine(contender: Any) -> str:
    """The package of a contender that cannot run here; "" for one that can."""
    return contender.engine if contender.missing else ""


def require(contender: Contender, problem: Problem) -> None:
    """Raise unless the contender can solve the problem here; errors as in `Contender.run`."""
    if not contender.supports(problem):
        raise ValueError(refusal(contender.name, [contender], problem))
    if contender.missing:
        why = f"{contender.name} cannot run: {contender.missing}"
        raise EngineMissing(why, name=missing_engine(contender))


def steps_of_run(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any], *keys: str
) -> FixedSteps:
    """The equal steps of a run, after `require`; the setting may also hold these keys."""
    require(contender, problem)
    check_keys(setting, ("step", "save_every", *keys))
    return fixed_steps(duration, setting)


def times_of_run(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any], *keys: str
) -> Array:
    """The times of a run's samples, after `require`; the setting may also hold these keys."""
    require(contender, problem)
    check_keys(setting, ("samples", *keys))
    return sample_times(problem.t0, duration, setting)
