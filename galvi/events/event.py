"""Events of a motion: where a function of its state crosses zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.nbody import NBody

Values = Callable[[Array, Array, Array], Array]  # (q, v, t) of n states -> (n,)


@runtime_checkable
class Quantity(Protocol):
    """A function of states that galvi brings: of many at once, once it knows the problem."""

    def of(self, problem: Problem) -> tuple[Values, Values | None, Values | None]:
        """The function; what an event reports, None: the function itself; and what must be
        positive at an event, None: nothing. ValueError for bodies or joints that are not there."""


@dataclass(frozen=True)
class Event:
    """A zero of function(q, v, t), a number, along a motion.

    function   of one configuration, one velocity and the time
    direction  +1 where it rises through zero, -1 where it falls, 0 both
    name       for tables
    """

    function: Callable[..., Any] | Quantity
    direction: int = 0
    name: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        if not (callable(self.function) or isinstance(self.function, Quantity)):
            raise TypeError(
                f"function must be a function of (q, v, t); received {shown(self.function)}."
            )
        if self.direction not in (-1, 0, 1):
            raise ValueError(f"direction must be -1, 0 or 1; received {shown(self.direction)}.")

    def values(self, problem: Problem) -> tuple[Values, Values, Values | None]:
        """The function of many states, what is reported, and what must be positive."""
        if isinstance(self.function, Quantity):
            found, reported, condition = self.function.of(problem)
            return found, reported or found, condition
        function = self.function

        def each(q: Array, v: Array, t: Array) -> Array:
            rows = zip(q, v, t.tolist(), strict=True)
            return np.array([input_checks.returned("an event", function(*row)) for row in rows])

        return each, each, None


def _body(problem: Problem, body: Any) -> int:
    """The number of a body, given by number or by name."""
    system: Any = problem.system
    if not isinstance(system, NBody):
        raise ValueError(f"this event is of point masses; received {shown(problem)}.")
    names = list(problem.body_names())
    if body in names:
        return names.index(body)
    if isinstance(body, int) and not isinstance(body, bool) and 0 <= body < len(names):
        return body
    raise ValueError(f"a body must be one of {names}, or its number; received {shown(body)}.")


@dataclass(frozen=True)
class Approach:
    """q . v of two bodies, whose distance is reported; see `galvi.events`."""

    one: Any
    other: Any

    def of(self, problem: Problem) -> tuple[Values, Values, None]:
        """As `Quantity`."""
        i, j = _body(problem, self.one), _body(problem, self.other)
        if i == j:
            raise ValueError(f"an event needs two bodies; received {shown(self.one)} twice.")

        def inward(q: Array, v: Array, t: Array) -> Array:
            found: Array = np.sum((q[:, i] - q[:, j]) * (v[:, i] - v[:, j]), axis=1)
            return found

        return inward, lambda q, v, t: np.linalg.norm(q[:, i] - q[:, j], axis=1), None


@dataclass(frozen=True)
class Distance:
    """The distance of two bodies less a number, relative to that."""

    one: Any
    other: Any
    distance: float

    def of(self, problem: Problem) -> tuple[Values, Values, None]:
        """As `Quantity`."""
        _, apart, _ = Approach(self.one, self.other).of(problem)
        far = self.distance
        return lambda q, v, t: (apart(q, v, t) / far) ** 2 - 1.0, apart, None


@dataclass(frozen=True)
class Transit:
    """The rate of the square of two bodies' distance on the sky, while i is in front of j."""

    one: Any
    other: Any
    observer: tuple[float, ...]

    def of(self, problem: Problem) -> tuple[Values, Values, Values]:
        """As `Quantity`."""
        i, j = _body(problem, self.one), _body(problem, self.other)
        towards = np.array(self.observer) / np.linalg.norm(self.observer)
        if towards.size != problem.q0.shape[1]:
            raise ValueError(
                f"observer must have {problem.q0.shape[1]} components; received {self.observer}."
            )

        def sky(x: Array) -> Array:
            gap = x[:, i] - x[:, j]
            found: Array = gap - (gap @ towards)[:, None] * towards
            return found

        return (
            lambda q, v, t: np.sum(sky(q) * sky(v), axis=1),
            lambda q, v, t: np.linalg.norm(sky(q), axis=1),
            lambda q, v, t: (q[:, i] - q[:, j]) @ towards,
        )


@dataclass(frozen=True)
class Plane:
    """normal . q - offset, of one body or of a particle."""

    normal: tuple[float, ...]
    offset: float
    body: Any

    def of(self, problem: Problem) -> tuple[Values, None, None]:
        """As `Quantity`."""
        normal, many = np.array(self.normal), problem.q0.ndim == 2
        if many and self.body is None:
            raise ValueError("of point masses a plane is crossed by one; give body.")
        row = _body(problem, self.body) if self.body is not None else None
        if problem.q0.shape[-1:] != normal.shape:
            raise ValueError(
                f"normal must have {problem.q0.shape[-1]} components; received {self.normal}."
            )
        if row is None:
            return lambda q, v, t: q @ normal - self.offset, None, None
        return lambda q, v, t: q[:, row] @ normal - self.offset, None, None


@dataclass(frozen=True)
class Angle:
    """A joint's angle, or a coordinate, at a value up to whole turns."""

    joint: Any
    value: float

    def of(self, problem: Problem) -> tuple[Values, Values, Values]:
        """As `Quantity`."""
        if problem.q0.ndim != 1:
            raise ValueError(f"an angle is a coordinate of a vector; received {shown(problem)}.")
        k = self.joint
        if not isinstance(k, int) or isinstance(k, bool) or not 0 <= k < problem.q0.size:
            raise ValueError(
                f"joint must be a number below {problem.q0.size}; received {shown(self.joint)}."
            )
        return (
            lambda q, v, t: np.sin(q[:, k] - self.value),
            lambda q, v, t: q[:, k],
            lambda q, v, t: np.cos(q[:, k] - self.value),
        )
