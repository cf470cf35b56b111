"""The values that an ensemble keeps of each run.

A `Keep` has two methods. ``steps(plan)`` returns the increasing numbers of the steps whose states
it needs; ``begin(plan)`` returns a `Record`, which receives these states of the members of a plan.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba.extending import is_jitted

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.events.event import as_events
from galvi.events.search import find_events
from galvi.input_checks import shown

TIME_SLACK = 1e-6  # of a step, by which a time may differ from a whole number of steps


class TimeGrid(NamedTuple):
    """The times of n members: ``steps`` steps of sizes ``step`` (n,) from t0.

    Attributes
    ----------
    q_shape, p_shape
        shapes of one configuration and one momentum
    """

    steps: int
    step: Array
    t0: float
    q_shape: tuple[int, ...]
    p_shape: tuple[int, ...]


class Record(Protocol):
    """The values of some members while they run."""

    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        """Receive all members after step k: t (n,), q (n, *q_shape) and p (n, *p_shape)."""

    def result(self) -> tuple[Array, ...]:
        """The kept arrays, with the members in front."""


class Keep(Protocol):
    """A value to keep of each run."""

    def steps(self, plan: TimeGrid) -> Sequence[int]:
        """The increasing numbers of steps, from 0 to plan.steps, whose states the record
        receives."""

    def begin(self, plan: TimeGrid) -> Record:
        """A record for the members of the plan."""


Quantity = Callable[[Array, Array, Array], Any]  # (t, q, p) of n members -> (n, ...)


def _check_callable(quantity: Any) -> None:
    if not callable(quantity):
        raise TypeError(f"quantity must be a function (t, q, p); received {shown(quantity)}.")


def _values(quantity: Quantity, t: Array, q: Array, p: Array) -> Array:
    """The values (n, ...) of a quantity for n members; ValueError unless its first axis has n."""
    try:
        x = np.asarray(quantity(t, q, p), dtype=np.float64)
    except (TypeError, ValueError) as error:
        error.add_note("This was the quantity of an ensemble, called with arrays of all members.")
        raise
    if x.shape[:1] != t.shape:
        raise ValueError(
            f"quantity must return a value for each of {len(t)} members, shape ({len(t)}, ...); "
            f"received shape {x.shape}. Compute it from arrays with the members in front."
        )
    return x


class _AtEachStep:
    """A `Keep` that needs the states at the start and after each step."""

    def steps(self, plan: TimeGrid) -> Sequence[int]:
        return range(plan.steps + 1)


@dataclass(frozen=True)
class FinalStates:
    """The last configuration and momentum of each member: ``result[0]`` and ``result[1]``.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> q, p = galvi.integrate_ensemble(problem, [problem.q0] * 8, problem.v0, method, 0.25, 40,
    ...                                 keep=galvi.FinalStates()).kept
    >>> q.shape, p.shape
    ((8, 2), (8, 2))
    """

    def steps(self, plan: TimeGrid) -> Sequence[int]:
        return [plan.steps]

    def begin(self, plan: TimeGrid) -> Record:
        return _FinalRecord()


class _FinalRecord:
    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        self.kept = np.array(q), np.array(p)

    def result(self) -> tuple[Array, ...]:
        return self.kept


@dataclass(frozen=True)
class StatesAt:
    """The states at given times.

    Parameters
    ----------
    times
        times in any order, each a whole number of steps of every member after the start; with a
        clock any times within the run

    Notes
    -----
    ``result[0]`` is (members, times, ...) of configurations, ``result[1]`` of momenta.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> galvi.integrate_ensemble(problem, [problem.q0] * 8, problem.v0, method, 0.25, 40,
    ...                          keep=galvi.StatesAt([2.5, 5.0, 10.0]))[0].shape
    (8, 3, 2)
    """

    times: Any

    def __post_init__(self) -> None:
        times = np.atleast_1d(input_checks.array("times", self.times))
        if times.ndim != 1:
            raise ValueError(f"times must have shape (times,); received shape {times.shape}.")
        object.__setattr__(self, "times", tuple(times.tolist()))

    def numbers(self, plan: TimeGrid) -> Any:
        """The numbers of steps (n, times); ValueError unless they are whole and within the run."""
        with np.errstate(over="ignore"):
            ratio = (np.array(self.times) - plan.t0) / plan.step[:, None]
        numbers = np.rint(np.clip(ratio, -1.0, plan.steps + 1.0))
        is_wrong = (np.abs(ratio - numbers) > TIME_SLACK) | (numbers < 0) | (numbers > plan.steps)
        if np.any(is_wrong):
            member, k = np.argwhere(is_wrong)[0]
            raise ValueError(
                f"times must be whole numbers of steps after t0, within the run; received "
                f"{self.times[k]!r}, which is {ratio[member, k]:.9g} steps of "
                f"{plan.step[member]:g} of a run of {plan.steps}."
            )
        return numbers.astype(np.int64)

    def steps(self, plan: TimeGrid) -> Sequence[int]:
        return [int(k) for k in np.unique(self.numbers(plan))]

    def begin(self, plan: TimeGrid) -> Record:
        return _StatesAtRecord(self.numbers(plan), plan)


class _StatesAtRecord:
    def __init__(self, numbers: Any, plan: TimeGrid) -> None:
        self.numbers = numbers
        self.q, self.p = (
            np.full((*numbers.shape, *shape), np.nan) for shape in (plan.q_shape, plan.p_shape)
        )

    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        members, columns = np.nonzero(self.numbers == k)
        self.q[members, columns], self.p[members, columns] = q[members], p[members]

    def result(self) -> tuple[Array, ...]:
        return self.q, self.p


@dataclass(frozen=True)
class Extrema(_AtEachStep):
    """The least and the largest value of a quantity at the steps, the start included.

    Parameters
    ----------
    quantity
        (t, q, p) of n members, (n,), (n, ...) and (n, ...), -> (n, ...); None: q

    Notes
    -----
    ``result[0]`` is the least value and ``result[1]`` the largest, (members, ...).

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> result = galvi.integrate_ensemble(problem, [problem.q0] * 8, problem.v0, method, 0.25, 40,
    ...                                   keep=galvi.Extrema(lambda t, q, p: np.hypot(*q.T)))
    >>> float(result[0][0].round(6)), result[1].shape  # the pericentre, at the start
    (0.7, (8,))
    """

    quantity: Quantity | None = None

    def __post_init__(self) -> None:
        if self.quantity is not None:
            _check_callable(self.quantity)

    def begin(self, plan: TimeGrid) -> Record:
        return _ExtremaRecord(self.quantity)


class _ExtremaRecord:
    def __init__(self, quantity: Quantity | None) -> None:
        self.quantity = quantity

    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        x = q if self.quantity is None else _values(self.quantity, t, q, p)
        if k == 0:
            self.smallest, self.largest = np.array(x), np.array(x)
        else:
            self.smallest, self.largest = np.minimum(self.smallest, x), np.maximum(self.largest, x)

    def result(self) -> tuple[Array, ...]:
        return self.smallest, self.largest


@dataclass(frozen=True)
class Histogram(_AtEachStep):
    """The number of states of each run, the start included, at which a quantity lies in each bin.

    Parameters
    ----------
    quantity
        (t, q, p) of n members, as for `Extrema`, -> (n,)
    edges : array, shape (bins + 1,)
        increasing; a value at the last edge belongs to the last bin

    Notes
    -----
    The result is (members, bins); a failed member counts nothing from its failure on.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> keep = galvi.Histogram(lambda t, q, p: np.hypot(*q.T), edges=[0.0, 1.0, 2.0])
    >>> result = galvi.integrate_ensemble(problem, [problem.q0] * 8, problem.v0, method, 0.25, 40,
    ...                                   keep=keep)
    >>> int(np.asarray(result)[0].sum())  # 40 steps and the start
    41
    """

    quantity: Quantity
    edges: Any

    def __post_init__(self) -> None:
        _check_callable(self.quantity)
        edges = input_checks.array("edges", self.edges)
        if edges.ndim != 1 or edges.size < 2 or np.any(np.diff(edges) <= 0.0):
            raise ValueError(
                f"edges must be at least two increasing numbers; received {edges.tolist()}."
            )
        object.__setattr__(self, "edges", tuple(edges.tolist()))

    def begin(self, plan: TimeGrid) -> Record:
        return _HistogramRecord(self.quantity, np.array(self.edges), len(plan.step))


class _HistogramRecord:
    def __init__(self, quantity: Quantity, edges: Array, members: int) -> None:
        self.quantity, self.edges = quantity, edges
        self.counts = np.zeros((members, edges.size - 1))

    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        x = _values(self.quantity, t, q, p)
        if x.ndim != 1:
            raise ValueError(
                f"the quantity of a histogram must return a number for each member, shape "
                f"{t.shape}; received shape {x.shape}."
            )
        bins = np.searchsorted(self.edges, x, side="right") - 1
        bins[x == self.edges[-1]] -= 1
        inside = np.flatnonzero((bins >= 0) & (bins < self.edges.size - 1) & np.isfinite(x))
        self.counts[inside, bins[inside]] += 1.0

    def result(self) -> tuple[Array, ...]:
        return (self.counts,)


@dataclass(frozen=True)
class OfStates(_AtEachStep):
    """A function compiled by ``numba.njit`` of the whole run of one member.

    Attributes
    ----------
    function
        (t (steps + 1,), q (steps + 1, ...), p (steps + 1, ...)) -> a number, or an array with the
        same shape for all members
    """

    function: Any

    def begin(self, plan: TimeGrid) -> Record:
        return _AllStates(self.function, plan)


class _AllStates:
    def __init__(self, function: Any, plan: TimeGrid) -> None:
        self.function, members, rows = function, len(plan.step), plan.steps + 1
        self.t = np.empty((members, rows))
        self.q, self.p = (
            np.empty((members, rows, *shape)) for shape in (plan.q_shape, plan.p_shape)
        )

    def see(self, k: int, t: Array, q: Array, p: Array) -> None:
        self.t[:, k], self.q[:, k], self.p[:, k] = t, q, p

    def result(self) -> tuple[Array, ...]:
        rows = zip(self.t, self.q, self.p, strict=True)
        values = [self.function(*(read_only(part) for part in row)) for row in rows]
        for value in values:
            if isinstance(value, tuple) or np.shape(value) != np.shape(values[0]):
                raise ValueError(
                    f"keep must return a number, or an array of one shape for all members; "
                    f"received {shown(value)}. Return one array."
                )
        return (np.array(values, dtype=np.float64),)


@dataclass(frozen=True)
class Events:
    """The first events of each member, found on its curves; members then run one by one.

    Parameters
    ----------
    events
        one `galvi.Event` or several, which neither end nor change a run
    at_most
        largest number of events that are kept of each member

    Notes
    -----
    The result is (members, at_most, 5) with the columns time, index of the event in ``events``,
    number of the step, value, and number of events of the member; where this exceeds ``at_most``,
    the later ones were left out. Rows after the last event are NaN except for that number, which is
    0 where a member had no event.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> problem = galvi.problems.kepler(0.5)
    >>> keep = galvi.Events(galvi.events.plane_crossing((0.0, 1.0)), at_most=2)
    >>> v0 = [problem.v0, 0.99 * problem.v0]
    >>> galvi.integrate_ensemble(problem, problem.q0, v0, method, 0.1, 80, keep=keep)[0].shape
    (2, 5)
    """

    events: Any
    at_most: int

    def __post_init__(self) -> None:
        event_tuple = as_events(self.events)
        if any(event.terminal or event.action is not None for event in event_tuple):
            raise ValueError(
                "in an ensemble events cannot end or change a run; received one with terminal or "
                "action. Use galvi.integrate_many(..., events=events)."
            )
        object.__setattr__(self, "events", event_tuple)
        object.__setattr__(self, "at_most", input_checks.whole("at_most", self.at_most))

    def __call__(self, run: Any) -> Array:
        """The rows (at_most, 5) of one run."""
        events = find_events(run, self.events)
        rows = np.full((self.at_most, 5), np.nan)
        n = min(len(events), self.at_most)
        rows[:n, :4] = np.stack([events.t, events.index, events.step, events.value], axis=1)[:n]
        rows[:, 4] = len(events)
        return rows


def keep_or_function(keep: Any) -> tuple[Keep | None, Callable[[Any], Any] | None]:
    """The `Keep` of an argument, or its Python function of a run; the other is None. TypeError for
    other arguments."""
    if keep is None:
        return FinalStates(), None
    if is_jitted(keep):
        return OfStates(keep), None
    if hasattr(keep, "begin") and hasattr(keep, "steps") and not isinstance(keep, type):
        return keep, None
    if callable(keep) and not isinstance(keep, type):
        return None, keep
    raise TypeError(
        f"keep must be a value such as galvi.FinalStates(), or a function; received {shown(keep)}."
    )
