"""Events of a motion: where a function of its state crosses zero."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.kernels.trees import tree
from galvi.problem import Problem
from galvi.run.energies import conserves_energy, start_energies
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody

Value = Callable[[Any, Any, Any], Any]  # (q, v, t) of one state -> a number
Change = Callable[[Any, Any, float], tuple[Any, Any]]  # (q, v, t) -> (q, v)


@runtime_checkable
class Quantity(Protocol):
    """A function of states that galvi brings, once it knows the problem."""

    def of(self, problem: Problem) -> tuple[Value, Value | None, Value | None]:
        """The function; what an event reports, None: the function itself; and what must be
        positive at an event, None: nothing. Entries are summed one by one, so that they may be
        those of many states. ValueError for bodies or joints that are not there."""


@dataclass(frozen=True)
class Event:
    """A zero of function(q, v, t), a number, along a motion.

    function   of one configuration, one velocity and the time
    direction  +1 where it rises through zero, -1 where it falls, 0 both; as the run goes
    terminal   whether `galvi.integrate` ends the run there
    action     (q, v, t) -> (q, v) from which `galvi.integrate` goes on; None: nothing changes
    name       for tables
    """

    function: Callable[..., Any] | Quantity
    direction: int = 0
    terminal: bool = False
    action: Change | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if not (callable(self.function) or isinstance(self.function, Quantity)):
            raise TypeError(
                f"function must be a function of (q, v, t); received {shown(self.function)}."
            )
        if type(self.direction) is not int or self.direction not in (-1, 0, 1):
            raise ValueError(f"direction must be -1, 0 or 1; received {shown(self.direction)}.")
        if not (self.action is None or callable(self.action)):
            raise TypeError(
                f"action must be a function of (q, v, t); received {shown(self.action)}."
            )
        if input_checks.flag("terminal", self.terminal) and self.action is not None:
            raise ValueError("an event ends the run or acts on it; received terminal and action.")

    @property
    def ends_or_acts(self) -> bool:
        """Whether a run does not go on as before."""
        return self.terminal or self.action is not None

    def functions(self, problem: Problem) -> tuple[Value, Value | None, Value | None]:
        """As those of a `Quantity`."""
        if isinstance(self.function, Quantity):
            return self.function.of(problem)
        return self.function, None, None


def several_events(events: Any) -> tuple[Event, ...]:
    """One event or several; TypeError for something else."""
    several = (events,) if isinstance(events, Event) else input_checks.several(events)
    for one in several:
        if not isinstance(one, Event):
            raise TypeError(
                f"events must be galvi.Event values, such as galvi.events.apsis(1, 0); received "
                f"{shown(one)}."
            )
    return several


def _body(problem: Problem, body: Any) -> int:
    """As `_number`, of point masses."""
    system: Any = problem.system
    if not isinstance(system, NBody):
        raise ValueError(f"this event is of point masses; received {shown(problem)}.")
    return _number("a body", body, list(problem.body_names()))


def _number(kind: str, one: Any, names: list[Any]) -> int:
    """The number of a body or coordinate, given by number or by name; "" is no name."""
    named = {name: k for k, name in enumerate(names) if name != ""}
    if isinstance(one, str) and one != "" and names.count(one) > 1:
        numbers_of_name = [k for k, name in enumerate(names) if name == one]
        raise ValueError(
            f"{kind} must have a name of its own; received {shown(one)}, the name of numbers "
            f"{numbers_of_name}. Give one of these numbers, or other names."
        )
    numbers = {k: k for k in range(len(names))} | named
    if isinstance(one, int | str) and not isinstance(one, bool) and one in numbers:
        return numbers[one]
    known = f"one of {list(named)}, or its number" if named else f"a number below {len(names)}"
    raise ValueError(f"{kind} must be {known}; received {shown(one)}.")


def _two_bodies(problem: Problem, one: Any, other: Any) -> tuple[int, int]:
    """The numbers of two bodies."""
    i, j = _body(problem, one), _body(problem, other)
    if i == j:
        raise ValueError(f"an event needs two bodies; received {shown(one)} twice.")
    return i, j


def _dot(one: Any, other: Any) -> Any:
    """The sum of products of entries."""
    first, *others = (a * b for a, b in zip(one, other, strict=True))
    return sum(others, first)


@dataclass(frozen=True)
class Approach:
    """q . v of two bodies, whose distance is reported; see `galvi.events`."""

    one: Any
    other: Any

    def of(self, problem: Problem) -> tuple[Value, Value, None]:
        i, j = _two_bodies(problem, self.one, self.other)

        def distance(q: Any, v: Any, t: Any) -> Any:
            gap = q[i] - q[j]
            return np.sqrt(_dot(gap, gap))

        return lambda q, v, t: _dot(q[i] - q[j], v[i] - v[j]), distance, None


@dataclass(frozen=True)
class Distance:
    """The square of two bodies' distance, relative to that of a number, less 1."""

    one: Any
    other: Any
    distance: float

    def of(self, problem: Problem) -> tuple[Value, Value, None]:
        i, j = _two_bodies(problem, self.one, self.other)
        _, apart, _ = Approach(i, j).of(problem)
        square = self.distance**2

        def relative(q: Any, v: Any, t: Any) -> Any:
            gap = q[i] - q[j]
            return _dot(gap, gap) / square - 1.0

        return relative, apart, None


@dataclass(frozen=True)
class Transit:
    """The rate of the square of two bodies' distance on the sky, while i is in front of j."""

    one: Any
    other: Any
    observer: tuple[float, ...]

    def of(self, problem: Problem) -> tuple[Value, Value, Value]:
        i, j = _two_bodies(problem, self.one, self.other)
        towards = np.array(self.observer) / np.linalg.norm(self.observer)
        if towards.size != problem.q0.shape[1]:
            raise ValueError(
                f"observer must have {problem.q0.shape[1]} components; received {self.observer}."
            )

        def sky(x: Any) -> Any:
            gap = x[i] - x[j]
            depth = _dot(gap, towards)
            return [a - depth * b for a, b in zip(gap, towards, strict=True)]

        def apart(q: Any, v: Any, t: Any) -> Any:
            gap = sky(q)
            return np.sqrt(_dot(gap, gap))

        return (
            lambda q, v, t: _dot(sky(q), sky(v)),
            apart,
            lambda q, v, t: _dot(q[i] - q[j], towards),
        )


@dataclass(frozen=True)
class Plane:
    """normal . q - offset, of one body or of a particle."""

    normal: tuple[float, ...]
    offset: float
    body: Any

    def of(self, problem: Problem) -> tuple[Value, None, None]:
        many = isinstance(problem.system, NBody)
        if many and self.body is None:
            raise ValueError("of point masses a plane is crossed by one; give body.")
        row = _body(problem, self.body) if self.body is not None else None
        if problem.q0.shape[-1:] != (len(self.normal),) or (not many and problem.q0.ndim != 1):
            raise ValueError(
                f"normal must have the components of a place, of {problem.q0.shape}; received "
                f"{self.normal}."
            )
        return (
            lambda q, v, t: _dot(q if row is None else q[row], self.normal) - self.offset,
            None,
            None,
        )


@dataclass(frozen=True)
class Angle:
    """A joint's angle, or a coordinate, at a value up to whole turns."""

    joint: Any
    value: float

    def of(self, problem: Problem) -> tuple[Value, Value, Value]:
        if problem.q0.ndim != 1:
            raise ValueError(f"an angle is a coordinate of a vector; received {shown(problem)}.")
        k = self._coordinate(problem)
        return (
            lambda q, v, t: np.sin(q[k] - self.value),
            lambda q, v, t: q[k],
            lambda q, v, t: np.cos(q[k] - self.value),
        )

    def _coordinate(self, problem: Problem) -> int:
        """The entry of q: by its number, or in a tree by the name of its hinge or slide."""
        system = problem.system
        if not isinstance(system, Multibody):
            return _number("a joint", self.joint, list(range(problem.q0.size)))
        names: list[Any] = []  # of the entries of q
        turned: dict[int, str] = {}  # entries of rotation matrices, of joints of that type
        for joint in system.tree.joints:
            turns = joint.number > tree.SLIDE
            if turns and self.joint == joint.name != "":
                raise ValueError(
                    f"a joint must have one angle or length; received {shown(self.joint)}, a "
                    f"{joint.type} joint. Give a galvi.Event with a function of (q, v, t)."
                )
            size = tree.ENTRIES[joint.number]
            if turns:
                turned |= {k: joint.type for k in range(len(names), len(names) + size)[-9:]}
            names += [""] * size if turns else [joint.name]
        k = _number("a joint", self.joint, names)
        if k in turned:
            raise ValueError(
                f"a joint must be a hinge or a slide, by its name or its entry of q; received "
                f"{shown(self.joint)}, an entry of the rotation matrix of a {turned[k]} joint."
            )
        return k


def changed(event: Event, problem: Problem, q: Array, v: Array, t: float) -> tuple[Array, Array]:
    """The state to which an action leads; ValueError for one that cannot be a state."""
    name = f"the action of the event {event.name}"
    try:
        found = cast(Any, event.action)(q.copy(), v.copy(), t)
    except Exception as error:
        error.add_note(f"This was {name}, at t = {t!r}.")
        raise
    if not isinstance(found, tuple | list) or len(found) != 2:
        raise ValueError(f"{name} must return (q, v); received {shown(found)}.")
    q = input_checks.array(f"q of {name}", found[0], problem.q0.shape)
    v = input_checks.array(f"v of {name}", found[1], problem.v0.shape)
    problem.system.check_state(q, v, t)
    if conserves_energy(problem.system):
        energy = start_energies(problem.moved(q, v, t)).total
        if not math.isfinite(energy):
            raise ValueError(f"{name} must lead to a finite energy; received {energy}.")
    return q, v
