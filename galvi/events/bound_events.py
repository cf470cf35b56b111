"""Events bound to a problem, with functions that are called for many states at once and checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.events.entries import Entry, evaluate_entries, lazy_entries
from galvi.events.event import Distances, Event, Value
from galvi.problem import Problem

COMPARED_STATES = 3  # states at which values by entries and one by one are compared
ENTRY_TOLERANCE = 1e-9  # their largest relative difference
BOUNDS_AT_ONCE = 2**20  # about as many bounds of pairs are computed at once

Row = Callable[[int], Array]  # index of an entry -> its values


class Function:
    """A function of an event, which is called for many states at once where that is possible.

    Attributes
    ----------
    name
        name of the event, for messages
    refusal
        why the function is called for one state after another; "" where it is called with entries

    Raises
    ------
    ValueError
        Where the function returns no finite number at the problem's start.
    """

    def __init__(self, value: Value, problem: Problem, name: str) -> None:
        self.value, self.name, self.refusal = value, name, ""
        self._traceable = getattr(value, "py_func", value)  # of Python where it is compiled
        self.shapes = problem.q0.shape, problem.v0.shape
        factors = 1.0 + 1e-3 * np.arange(COMPARED_STATES)
        q, v = (np.outer(x.ravel(), factors) for x in (problem.q0, problem.v0))
        t: Any = problem.t0 + 1e-3 * np.arange(COMPARED_STATES)
        first = self._call_one_by_one(q[:, :1], v[:, :1], t[:1])
        self._check(first, t[:1])
        try:
            vectorized = self._call_vectorized(q.__getitem__, v.__getitem__, t)
        except Exception as error:  # whatever the function raises with entries
            self.refusal = f"{type(error).__name__}: {error}".rstrip(".")
            return
        with np.errstate(all="ignore"):
            rows = np.append(first, self._call_one_by_one(q[:, 1:], v[:, 1:], t[1:]))
        if not np.allclose(
            vectorized,
            rows,
            rtol=ENTRY_TOLERANCE,
            atol=ENTRY_TOLERANCE * np.max(np.abs(rows), initial=0.0),
        ):
            self.refusal = "its values for many states at once differ from those one by one"

    def at(self, q: Array, v: Array, t: Array) -> Array:
        """Values (*t.shape) at states q and v whose first axis is that of entries, (r,
        *t.shape)."""
        return self.at_later(q.__getitem__, v.__getitem__, t)

    def at_later(self, coordinate: Row, velocity: Row, t: Array) -> Array:
        """As ``at``, with functions from the index of an entry to its values, which are called only
        for the entries that the event's function uses."""
        if self.refusal:
            q, v = (
                np.stack([row(k).ravel() for k in range(math.prod(shape))])
                for row, shape in zip((coordinate, velocity), self.shapes, strict=True)
            )
            values = self._call_one_by_one(q, v, t.ravel()).reshape(t.shape)
        else:
            values = self._call_vectorized(coordinate, velocity, t)
        self._check(values, t)
        return values

    def of(self, q: Array, v: Array, t: Array) -> Array:
        """Values (n,) at n states (n, ...)."""
        return self.at(q.reshape(len(t), -1).T, v.reshape(len(t), -1).T, t)

    def bounds(self, q: Any, v: Any, t: Any) -> tuple[Array, Array]:
        """Lower and upper bounds on each step, from entries that hold bounds."""
        q, v = q.reshape(self.shapes[0]), v.reshape(self.shapes[1])
        return evaluate_entries(self._traceable, q, v, t, t.low.shape)

    def _call_vectorized(self, coordinate: Row, velocity: Row, t: Any) -> Array:
        q, v = (
            lazy_entries(partial(_equal_bounds, row), math.prod(shape)).reshape(shape)
            for row, shape in zip((coordinate, velocity), self.shapes, strict=True)
        )
        return evaluate_entries(self._traceable, q, v, Entry(t, t), t.shape)[0]

    def _call_one_by_one(self, q: Array, v: Array, t: Array) -> Array:
        """Values (n,) of states (r, n), one after another."""
        values, (q_shape, v_shape) = np.empty(len(t)), self.shapes
        for k, time in enumerate(t.tolist()):
            try:
                value = self.value(q[:, k].reshape(q_shape), v[:, k].reshape(v_shape), time)
            except Exception as error:
                error.add_note(f"This was the event {self.name}, at t = {time!r}.")
                raise
            values[k] = input_checks.returned(f"the event {self.name}", value)
        return values

    def _check(self, values: Array, t: Array) -> None:
        not_finite = np.flatnonzero(~np.isfinite(values.ravel()))
        if not_finite.size:
            raise ValueError(
                f"the event {self.name} must be a finite number along the run; received "
                f"{values.ravel()[not_finite[0]]} at t = {t.ravel()[not_finite[0]]:.10g}."
            )


def _equal_bounds(find: Row, k: int) -> tuple[Array, Array]:
    """The values of entry k as both lower and upper bounds."""
    values = find(k)
    return values, values


class BoundEvent:
    """An event of one problem, and its functions."""

    def __init__(self, event: Event, problem: Problem, number: int) -> None:
        self.event, self.number, self.name = event, number, event.name or f"number {number}"
        functions: Any = [
            function and Function(function, problem, self.name)
            for function in event.functions(problem)
        ]
        self.function, reported, self.condition = functions
        self.reported = reported or self.function

    def name_of(self, part: int) -> str:
        """The name of its occurrences."""
        return self.event.name


class BoundPairs:
    """An event of many pairs of bodies of one problem; ``of_pair(k)`` is the event of pair k."""

    def __init__(self, event: Event, problem: Problem, number: int) -> None:
        self.event, self.number, self.problem = event, number, problem
        self.distances = cast(Distances, event.function)
        self.pairs, self.names = self.distances.pairs(problem), problem.body_names()
        self.of_pair = cache(self._of_pair)

    def _of_pair(self, k: int) -> BoundEvent:
        function = self.distances.one_of(*self.pairs[k].tolist())
        pair_event = replace(self.event, function=function, name=self.name_of(k))
        return BoundEvent(pair_event, self.problem, self.number)

    def name_of(self, part: int) -> str:
        """The name of the occurrences of pair ``part``."""
        i, j = self.pairs[part].tolist()
        return self.distances.name_of(self.names[i], self.names[j])

    def bounds(self, low: Array, high: Array) -> Iterator[tuple[Any, Array, Array]]:
        """Indices of pairs (k,) and lower and upper bounds (k, steps) of their functions, chunk by
        chunk, from bounds (d, steps) of coordinates."""
        shape = (*self.problem.q0.shape, -1)
        low, high = low.reshape(shape), high.reshape(shape)
        at_once = max(1, BOUNDS_AT_ONCE // low[0].size)
        for first in range(0, len(self.pairs), at_once):
            rows = np.arange(first, min(first + at_once, len(self.pairs)))
            yield rows, *self.distances.bounds(self.problem, self.pairs[rows], low, high)
