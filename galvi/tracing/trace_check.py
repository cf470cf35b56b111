"""Checks that a trace has the values of its function, up to rounding errors.

Bounds on rounding errors are by running error analysis (N. Higham, Accuracy and Stability of
Numerical Algorithms (2002), 3.3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.constants import EPSILON
from galvi.lanes.group_collocation import Chart
from galvi.systems.traces import Untraceable
from galvi.tracing.graph import UNARY, Node
from galvi.tracing.graph_code import reachable
from galvi.tracing.lane_law import function_of


def values_and_bounds(nodes: Sequence[Node], values: Mapping[str, Any]) -> tuple[Array, Array]:
    """Values of nodes (k, ...) and bounds of their rounding errors, from values of the variables.

    Parameters
    ----------
    values
        name of a variable, such as "q[0]" -> its values

    Notes
    -----
    Where an expression is undefined, both are NaN or infinite.
    """
    x: dict[int, Any] = {}
    error: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for node in reachable(nodes):
            value: Any
            bound: Any
            if node.kind == "variable":
                value, bound = np.asarray(values[node.arguments[0]], dtype=np.float64), 0.0
            elif node.kind == "number":
                value, bound = np.float64(node.value), 0.0
            else:
                operands = [y.index if isinstance(y, Node) else y for y in node.arguments]
                value, bound = _operation(
                    node.kind,
                    [x[k] if isinstance(k, int) else k for k in operands],
                    [error[k] if isinstance(k, int) else 0.0 for k in operands],
                )
            x[node.index], error[node.index] = value, bound + EPSILON * np.abs(value)
    shape = np.broadcast_shapes(*(np.shape(sample) for sample in values.values()))
    rows = [x[node.index] for node in nodes], [error[node.index] for node in nodes]
    first, second = (np.array([np.broadcast_to(entry, shape) for entry in row]) for row in rows)
    return first, second


def _operation(kind: str, x: Sequence[Any], e: Sequence[Any]) -> tuple[Any, Any]:
    """The value of an operation on x, and the part of its error from the errors e of x."""
    if kind in ("+", "-"):
        return (x[0] + x[1] if kind == "+" else x[0] - x[1]), e[0] + e[1]
    if kind == "*":
        return x[0] * x[1], np.abs(x[1]) * e[0] + np.abs(x[0]) * e[1]
    if kind == "atan2":
        square = x[0] * x[0] + x[1] * x[1]
        return np.arctan2(*x), (np.abs(x[1]) * e[0] + np.abs(x[0]) * e[1]) / square
    if kind == "power":
        value = x[0] ** x[1]
        by_log = np.where(e[1] > 0.0, np.abs(np.log(np.abs(x[0]))) * e[1], 0.0)
        return value, np.abs(value) * (np.abs(x[1] / x[0]) * e[0] + by_log)
    if kind == "inverse":
        value = 1.0 / x[0]
        return value, value * value * e[0]
    assert kind in UNARY
    value = getattr(np, kind)(x[0])
    slope = {
        "sin": 1.0,
        "cos": 1.0,
        "tan": 1.0 + value * value,
        "exp": value,
        "log": 1.0 / x[0],
        "sqrt": 0.5 / value,
        "sinh": np.cosh(x[0]),
        "cosh": np.sinh(x[0]),
        "tanh": 1.0,
    }[kind]
    return value, np.abs(slope) * e[0]


# Number of states at which a function is compared, and smallest number that must be finite.
COMPARED_STATES, MIN_FINITE_STATES = 8, 3
STATE_DISTANCE = 0.4  # distance of these states from the start, over the scales of a function
ALLOWED_ERROR_BOUNDS = (
    64.0  # bounds on the rounding error that a difference from the function may have
)
DIFFERENCE_STEPS = 2.0**-17, 2.0**-25  # of differences, over the scales of the function
DIFFERENCE_ACCURACY = (
    1e-3  # of a difference, relative to its terms; that of a slope left out is about 1
)
CAYLEY = 0  # the chart, of which only the derivative at 0 matters, that moves states


@dataclass(frozen=True, eq=False)
class States:
    """Entries q (n, r) of elements of a group, v (n, d) and t (n,) of n states."""

    group: Group
    q: Array
    v: Array
    t: Array

    @classmethod
    def around(cls, group: Group, q: Array, v: Array, t: float, scales: Sequence[Array]) -> States:
        """COMPARED_STATES states: the start, then random states at decreasing distances from it."""
        random = np.random.default_rng(20)
        distances = np.append(0.0, STATE_DISTANCE * 0.7 ** np.arange(COMPARED_STATES - 1.0))[
            :, None
        ]
        by_q, by_v, by_t = (
            random.uniform(-1.0, 1.0, (COMPARED_STATES, k)) for k in (v.size, v.size, 1)
        )
        time = t + (abs(t) or 1.0) * (distances * by_t)[:, 0]
        start = cls(
            group,
            np.tile(np.ravel(q), (COMPARED_STATES, 1)),
            np.tile(v, (COMPARED_STATES, 1)),
            time,
        )
        return start.moved(1.0, distances * by_q * scales[0], distances * by_v * scales[1])

    def moved(self, distance: float, by_q: Array, by_v: Array) -> States:
        """The states with q moved by ``distance`` times by_q (n, d) in the group's chart, and v by
        ``distance`` times by_v (n, d)."""
        rows = zip(self.q.tolist(), (distance * by_q).tolist(), strict=True)
        chart = self.chart
        q = np.array([chart.place(g, xi) for g, xi in rows])
        return States(self.group, q, self.v + distance * by_v, self.t)

    @property
    def chart(self) -> Chart:
        """The group in a chart, for numbers and nodes."""
        return Chart(self.group.layout.tolist(), CAYLEY)

    @property
    def values(self) -> dict[str, Array]:
        """Name of a variable of expressions -> its values (n,)."""
        columns = {f"{name}[{i}]": x for name in "qv" for i, x in enumerate(getattr(self, name).T)}
        return {**columns, "t": self.t}

    def arguments(self, k: int, takes: str) -> tuple[Any, ...]:
        """The arguments ``takes`` of a function at state k."""
        q = self.q[k].reshape(self.group.shape)
        by_name = {"q": q.copy(), "v": self.v[k].copy(), "t": float(self.t[k])}
        return tuple(by_name[name] for name in takes)


@dataclass(frozen=True, eq=False)
class Sample:
    """The numbers that a function returned at n states.

    Attributes
    ----------
    takes
        the arguments of the function, e.g. "qv" or "qvt"
    returned : array, shape (n, k)
        the numbers; NaN where the function raised an exception
    """

    function: Callable[..., Any]
    states: States
    takes: str
    returned: Array

    @classmethod
    def of(cls, function: Callable[..., Any], states: States, takes: str, size: int) -> Sample:
        """A sample of a function of ``size`` numbers at these states.

        Call it before tracing: an object that creates a constant in its first call then creates it
        from numbers.
        """
        rows = [
            _returned_numbers(function, states.arguments(k, takes), size)
            for k in range(len(states.t))
        ]
        return cls(function, states, takes, np.array(rows))

    @property
    def holds(self) -> bool:
        """Whether the function still returns the same numbers at these states."""
        again = Sample.of(self.function, self.states, self.takes, self.returned.shape[1])
        return np.array_equal(again.returned, self.returned, equal_nan=True)


def _returned_numbers(function: Callable[..., Any], arguments: tuple[Any, ...], size: int) -> Array:
    """The numbers (size,) that a function returns; NaN if it raises an exception or returns other
    than ``size`` real numbers."""
    try:
        with np.errstate(all="ignore"):
            returned = np.asarray(function(*arguments))
            if returned.dtype.kind not in "iufO":
                return np.full(size, np.nan)
            numbers = returned.astype(np.float64).ravel()
    except Exception:  # a user's function can raise any exception
        return np.full(size, np.nan)
    return numbers if numbers.size == size else np.full(size, np.nan)


def check_values(sample: Sample, nodes: Sequence[Node]) -> Sample:
    """The sample itself; raises `Untraceable` unless the nodes have its values, up to their
    rounding errors."""
    values, error = (x.T for x in values_and_bounds(nodes, sample.states.values))
    with np.errstate(invalid="ignore"):
        differs = np.abs(values - sample.returned) > ALLOWED_ERROR_BOUNDS * error
    finite = np.all(np.isfinite(sample.returned), axis=1)
    if not finite[0] or np.sum(finite) < MIN_FINITE_STATES:
        raise Untraceable("it is not finite at the start, or near it")
    if np.any(differs[finite]) or not np.all(np.isfinite(values[finite])):
        raise Untraceable("called with numbers it returns something else than with symbols")
    return sample


def check_slopes(
    value: Node,
    by_q: Sequence[Node],
    by_v: Sequence[Node],
    states: States,
    scales: Sequence[Array],
) -> None:
    """Raise `Untraceable` unless the nodes are the derivatives of ``value``, and finite at the
    start.

    Parameters
    ----------
    by_q
        d derivatives along q hat(e_a)
    by_v
        d derivatives by v; () for a value that does not depend on v
    """
    slopes = values_and_bounds([*by_q, *by_v], states.values)[0].T
    _refuse_undefined(slopes)
    along_q, along_v = _directions(states, scales)
    terms = slopes * np.concatenate([along_q, along_v], axis=1)[:, : slopes.shape[1]]
    _compare(
        lambda distance: values_and_bounds(
            [value], states.moved(distance, along_q, along_v).values
        ),
        np.sum(terms, axis=1)[None],
        np.sum(np.abs(terms), axis=1)[None],
    )


def check_mass(
    law: str,
    constants: Sequence[float],
    slopes_of_L: Sequence[Node],
    states: States,
    scales: Sequence[Array],
) -> None:
    """Raise `Untraceable` unless the code of a law has these slopes, and as mass the derivatives of
    dL/dv by v.

    Parameters
    ----------
    slopes_of_L
        dL/dv and the derivatives along q hat(e_a), 2 d nodes
    """
    d = len(slopes_of_L) // 2
    with np.errstate(all="ignore"):
        q, v = states.q.T, states.v.T
        forces, momenta, rows = function_of(law)(list(q), list(v), states.t, constants)
    slopes = np.array([np.broadcast_to(x, states.t.shape) for x in (*momenta, *forces)])
    traced_slopes, error = values_and_bounds(slopes_of_L, states.values)
    with np.errstate(invalid="ignore"):
        if np.any(np.abs(slopes - traced_slopes) > ALLOWED_ERROR_BOUNDS * error):
            raise Untraceable("its generated code is wrong")
    mass = np.empty((d, d, states.t.size))
    for i in range(d):
        for j in range(i + 1):
            mass[i, j] = mass[j, i] = rows[i][j]
    _refuse_undefined(np.moveaxis(mass, 2, 0))
    _, by_v = _directions(states, scales)
    terms = mass * by_v.T
    _compare(
        lambda distance: values_and_bounds(
            slopes_of_L[:d], states.moved(distance, 0.0 * by_v, by_v).values
        ),
        np.sum(terms, axis=1),
        np.sum(np.abs(terms), axis=1),
    )


def _refuse_undefined(derivatives: Array) -> None:
    if not np.all(np.isfinite(derivatives[0])):
        raise Untraceable("its derivatives are not finite at the start")


def _directions(states: States, scales: Sequence[Array]) -> tuple[Array, Array]:
    random = np.random.default_rng(21)
    by_q, by_v = (random.uniform(0.5, 1.0, states.v.shape) * scale for scale in scales)
    return by_q, by_v


def _compare(
    moved: Callable[[float], tuple[Array, Array]], derivative: Array, terms: Array
) -> None:
    """Raise `Untraceable` unless a derivative (k, n) is a difference quotient for one of the steps.

    Parameters
    ----------
    moved
        distance -> values and rounding errors (k, n)
    terms
        sizes (k, n) of the derivative's terms
    """
    agrees = np.zeros(derivative.shape, dtype=bool)
    for step in DIFFERENCE_STEPS:
        (ahead, first), (behind, second) = moved(step), moved(-step)
        with np.errstate(all="ignore"):
            difference = np.abs((ahead - behind) / (2.0 * step) - derivative)
            limit = (
                DIFFERENCE_ACCURACY * (terms + 1e-3 * np.max(terms, axis=0))
                + (first + second) / step
            )
            agrees |= ~(difference > limit)
    if not np.all(agrees):
        raise Untraceable("its derivatives are not those of the function")
