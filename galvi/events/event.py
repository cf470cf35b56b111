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
    """A ready function of states, which is made for a problem."""

    def of(self, problem: Problem) -> tuple[Value, Value | None, Value | None]:
        """The function whose zeros are events; the function that an event reports, None for the
        same one; and a function that must be positive at an event, None for no condition. They sum
        entries one by one, so that these may hold many states. ValueError for bodies or joints that
        the problem does not have."""


@dataclass(frozen=True)
class Event:
    """A zero of function(q, v, t), a number, along a motion.

    Parameters
    ----------
    function
        (q, v, t) -> number, of one configuration, one velocity and the time
    direction
        +1: events are where the function rises through zero in the course of the run, -1: where it
        falls, 0: both
    terminal
        whether `galvi.integrate` ends the run at the first event
    action
        (q, v, t) -> (q, v), the state from which `galvi.integrate` goes on; None: no change
    name
        name of the event in tables and messages

    Raises
    ------
    TypeError
        For a ``function`` or ``action`` that cannot be called, and a ``terminal`` that is no bool.
    ValueError
        For another ``direction``, and for ``terminal`` together with an ``action``.

    Examples
    --------
    >>> galvi.Event(lambda q, v, t: q[0] - 0.5, direction=-1, name="half way").direction
    -1
    """

    function: Callable[..., Any] | Quantity | Distances
    direction: int = 0
    terminal: bool = False
    action: Change | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if not (callable(self.function) or isinstance(self.function, Quantity | Distances)):
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
            raise ValueError(
                "an event ends the run or acts on it; received terminal=True with an action. Leave "
                "one of the two out."
            )

    @property
    def ends_or_acts(self) -> bool:
        """Whether the event ends or changes a run."""
        return self.terminal or self.action is not None

    def functions(self, problem: Problem) -> tuple[Value, Value | None, Value | None]:
        """The functions that `Quantity.of` returns."""
        if isinstance(self.function, Quantity):
            return self.function.of(problem)
        return cast(Value, self.function), None, None


def as_events(events: Any) -> tuple[Event, ...]:
    """One event or several as a tuple; TypeError for values that are no `Event`."""
    event_tuple = (events,) if isinstance(events, Event) else input_checks.several(events)
    for event in event_tuple:
        if not isinstance(event, Event):
            raise TypeError(
                f"events must be galvi.Event values, such as galvi.events.apsis(1, 0); received "
                f"{shown(event)}."
            )
    return event_tuple


def _body(problem: Problem, body: Any) -> int:
    """The number of a point mass, see `_number`."""
    if not isinstance(problem.system, NBody):
        raise ValueError(
            f"this event needs point masses, a galvi.NBody system; received {shown(problem)}."
        )
    return _number("a body", body, list(problem.body_names()))


def _number(kind: str, key: Any, names: list[Any]) -> int:
    """The number of a body or coordinate, given by number or by name; "" is no name."""
    numbers_by_name = {name: k for k, name in enumerate(names) if name != ""}
    if isinstance(key, str) and key != "" and names.count(key) > 1:
        numbers_of_name = [k for k, name in enumerate(names) if name == key]
        raise ValueError(
            f"{kind} must have a name of its own; received {shown(key)}, the name of numbers "
            f"{numbers_of_name}. Give one of these numbers, or other names."
        )
    numbers = {k: k for k in range(len(names))} | numbers_by_name
    if isinstance(key, int | str) and not isinstance(key, bool) and key in numbers:
        return numbers[key]
    choices = (
        f"one of {list(numbers_by_name)}, or its number"
        if numbers_by_name
        else f"a number below {len(names)}"
    )
    raise ValueError(f"{kind} must be {choices}; received {shown(key)}.")


def _two_bodies(problem: Problem, first: Any, second: Any) -> tuple[int, int]:
    """The numbers of two bodies."""
    i, j = _body(problem, first), _body(problem, second)
    if i == j:
        raise ValueError(f"an event needs two bodies; received {shown(first)} twice.")
    return i, j


def _dot(left: Any, right: Any) -> Any:
    """The sum of products of entries."""
    first, *products = (a * b for a, b in zip(left, right, strict=True))
    return sum(products, first)


@dataclass(frozen=True)
class Approach:
    """q . v of the relative motion of two bodies; reports their distance. See `galvi.events`."""

    first: Any
    second: Any

    def of(self, problem: Problem) -> tuple[Value, Value, None]:
        i, j = _two_bodies(problem, self.first, self.second)

        def distance(q: Any, v: Any, t: Any) -> Any:
            gap = q[i] - q[j]
            return np.sqrt(_dot(gap, gap))

        return lambda q, v, t: _dot(q[i] - q[j], v[i] - v[j]), distance, None


@dataclass(frozen=True)
class Distance:
    """The square of two bodies' distance over the square of a threshold, less 1.

    Attributes
    ----------
    threshold
        a distance, or a number of Hill radii
    hill
        whether the threshold is in Hill radii, ((m_i + m_j) / (3 M))^(1/3) (r_i + r_j) / 2, where M
        is the largest mass and r_i, r_j are the distances from its body
    """

    first: Any
    second: Any
    threshold: float
    hill: bool

    def of(self, problem: Problem) -> tuple[Value, Value, None]:
        i, j = _two_bodies(problem, self.first, self.second)
        _, distance, _ = Approach(i, j).of(problem)
        (hill_share,), star = _hill_factors(problem, np.array([[i, j]]))
        if self.hill and star in (i, j):
            raise ValueError(
                f"the heaviest body has no Hill radius; received {shown(self.first)} and "
                f"{shown(self.second)}. Give a distance."
            )
        factor = self.threshold * hill_share

        def relative(q: Any, v: Any, t: Any) -> Any:
            gap, radius = q[i] - q[j], self.threshold
            if self.hill:
                gap_i, gap_j = q[i] - q[star], q[j] - q[star]
                radius = factor * (np.sqrt(_dot(gap_i, gap_i)) + np.sqrt(_dot(gap_j, gap_j)))
            return _dot(gap, gap) / radius**2 - 1.0

        return relative, distance, None


def _hill_factors(problem: Problem, pairs: Any) -> tuple[Array, int]:
    """The Hill radii (n,) of pairs over the sums of both distances from the heaviest body, and the
    number of that body."""
    masses = cast(NBody, problem.system).masses
    star = int(np.argmax(masses))
    return 0.5 * np.cbrt(masses[pairs].sum(axis=1) / (3.0 * masses[star])), star


ANY = "any"


@dataclass(frozen=True)
class Distances:
    """`Distance` of all pairs of bodies, or of one body and all others, searched together: see
    `galvi.events.within`.

    Attributes
    ----------
    first, second
        bodies, or ANY
    """

    first: Any
    second: Any
    threshold: float
    hill: bool

    def pairs(self, problem: Problem) -> Any:
        """The numbers (n, 2) of the bodies; ValueError for bodies that are not in the problem."""
        _body(problem, 0)
        masses = cast(NBody, problem.system).masses
        pairs = np.argwhere(np.triu(np.ones((masses.size, masses.size), dtype=bool), 1))
        for body in (self.first, self.second):
            if body != ANY:
                pairs = pairs[(pairs == _body(problem, body)).any(axis=1)]
        if self.hill:
            pairs = pairs[(pairs != int(np.argmax(masses))).all(axis=1)]
        if not len(pairs):
            raise ValueError(f"there is no such pair of bodies in {shown(problem)}.")
        return pairs

    def one_of(self, i: int, j: int) -> Quantity:
        """The `Distance` of two bodies."""
        return Distance(i, j, self.threshold, self.hill)

    def name_of(self, i: Any, j: Any) -> str:
        """The name of an event of two bodies with these names."""
        return f"{i} and {j} at {self.threshold:g}{' Hill radii' * self.hill}"

    def bounds(self, problem: Problem, pairs: Any, low: Array, high: Array) -> tuple[Array, Array]:
        """Lower and upper bounds (n, steps) of the pairs' functions, from bounds (bodies, D, steps)
        of positions."""
        i, j = pairs.T
        low_square, high_square = _squares(low[i] - high[j], high[i] - low[j])
        low_limit: Any = self.threshold**2
        high_limit = low_limit
        if self.hill:
            shares, star = _hill_factors(problem, pairs)
            star_squares = _squares(low - high[star], high - low[star])
            low_limit, high_limit = (
                (self.threshold * shares[:, None] * (r[i] + r[j])) ** 2
                for r in map(np.sqrt, star_squares)
            )
        with np.errstate(all="ignore"):
            return low_square / high_limit - 1.0, high_square / low_limit - 1.0


def _squares(low: Array, high: Array) -> tuple[Array, Array]:
    """Lower and upper bounds (k, steps) of the squares of vectors, from bounds (k, D, steps) of
    their components."""
    smallest = np.maximum(np.maximum(low, -high), 0.0)
    largest = np.maximum(-low, high)
    return np.einsum("kds,kds->ks", smallest, smallest), np.einsum("kds,kds->ks", largest, largest)


@dataclass(frozen=True)
class Transit:
    """Half the rate of the square of two bodies' distance on the sky, where i is in front of j."""

    first: Any
    second: Any
    observer: tuple[float, ...]

    def of(self, problem: Problem) -> tuple[Value, Value, Value]:
        i, j = _two_bodies(problem, self.first, self.second)
        direction = np.array(self.observer) / np.linalg.norm(self.observer)
        if direction.size != problem.q0.shape[1]:
            raise ValueError(
                f"observer must have {problem.q0.shape[1]} components; received {self.observer}."
            )

        def on_sky(x: Any) -> Any:
            gap = x[i] - x[j]
            depth = _dot(gap, direction)
            return [a - depth * b for a, b in zip(gap, direction, strict=True)]

        def sky_distance(q: Any, v: Any, t: Any) -> Any:
            gap = on_sky(q)
            return np.sqrt(_dot(gap, gap))

        return (
            lambda q, v, t: _dot(on_sky(q), on_sky(v)),
            sky_distance,
            lambda q, v, t: _dot(q[i] - q[j], direction),
        )


@dataclass(frozen=True)
class Plane:
    """normal . q - offset, of one body or of a particle."""

    normal: tuple[float, ...]
    offset: float
    body: Any

    def of(self, problem: Problem) -> tuple[Value, None, None]:
        is_point_masses = isinstance(problem.system, NBody)
        if is_point_masses and self.body is None:
            raise ValueError(
                "body must be the point mass that crosses the plane; received None. Give a number "
                "or a name."
            )
        row = _body(problem, self.body) if self.body is not None else None
        if problem.q0.shape[-1:] != (len(self.normal),) or (
            not is_point_masses and problem.q0.ndim != 1
        ):
            raise ValueError(
                f"normal must have the components of one position, of a configuration (d,) or "
                f"(bodies, d); received {self.normal} and {problem.q0.shape}."
            )
        return (
            lambda q, v, t: _dot(q if row is None else q[row], self.normal) - self.offset,
            None,
            None,
        )


@dataclass(frozen=True)
class Angle:
    """sin(q_k - value) of a joint's angle or another coordinate q_k."""

    joint: Any
    value: float

    def of(self, problem: Problem) -> tuple[Value, Value, Value]:
        if problem.q0.ndim != 1:
            raise ValueError(
                f"an angle is a coordinate of a vector; received {shown(problem)}. Give a "
                f"galvi.Event with a function of (q, v, t)."
            )
        k = self._coordinate(problem)
        return (
            lambda q, v, t: np.sin(q[k] - self.value),
            lambda q, v, t: q[k],
            lambda q, v, t: np.cos(q[k] - self.value),
        )

    def _coordinate(self, problem: Problem) -> int:
        """The index of the coordinate in q."""
        system = problem.system
        if not isinstance(system, Multibody):
            return _number("a joint", self.joint, list(range(problem.q0.size)))
        names: list[Any] = []  # of the entries of q
        joint_types: dict[int, str] = {}  # entries of rotation matrices, of joints of that type
        for joint in system.tree.joints:
            is_rotation = joint.number > tree.SLIDE
            if is_rotation and self.joint == joint.name != "":
                raise ValueError(
                    f"a joint must have one angle or length; received {shown(self.joint)}, a "
                    f"{joint.type} joint. Give a galvi.Event with a function of (q, v, t)."
                )
            size = tree.ENTRIES[joint.number]
            if is_rotation:
                joint_types |= {k: joint.type for k in range(len(names), len(names) + size)[-9:]}
            names += [""] * size if is_rotation else [joint.name]
        k = _number("a joint", self.joint, names)
        if k in joint_types:
            raise ValueError(
                f"a joint must be a hinge or a slide, by its name or its entry of q; received "
                f"{shown(self.joint)}, an entry of the rotation matrix of a {joint_types[k]} joint."
            )
        return k


def state_after_action(
    event: Event, problem: Problem, q: Array, v: Array, t: float
) -> tuple[Array, Array]:
    """The state (q, v) that an event's action returns; ValueError for values that are no state, and
    for a state whose conserved energy is not finite."""
    name = f"the action of the event {event.name}"
    try:
        state = cast(Any, event.action)(q.copy(), v.copy(), t)
    except Exception as error:
        error.add_note(f"This was {name}, at t = {t!r}.")
        raise
    if not isinstance(state, tuple | list) or len(state) != 2:
        raise ValueError(f"{name} must return (q, v); received {shown(state)}.")
    q = input_checks.array(f"q of {name}", state[0], problem.q0.shape)
    v = input_checks.array(f"v of {name}", state[1], problem.v0.shape)
    problem.system.check_state(q, v, t)
    if conserves_energy(problem.system):
        energy = start_energies(problem.moved(q, v, t)).total
        if not math.isfinite(energy):
            raise ValueError(f"{name} must lead to a finite energy; received {energy}.")
    return q, v
