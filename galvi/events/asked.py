"""An event of one problem: its function called for many states at once, and checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.events.entries import Entry, computed, entries
from galvi.events.event import Event
from galvi.problem import Problem

AGREES = 1e-9  # of a function's values, to which those of entries are its own
TRIED = 3  # states at which that is seen


class Asked:
    """An event of one problem, whose function is called for many states at once where it can be.

    refusal  why it is called for one after another; "" for a function that could be traced
    """

    def __init__(self, event: Event, problem: Problem, number: int) -> None:
        self.event, self.number = event, number
        self.name = event.name or f"number {number}"
        self.shapes = problem.q0.shape, problem.v0.shape
        self.function, self.reported, self.condition = event.functions(problem)
        self.refusal = ""
        shares = 1.0 + 1e-3 * np.arange(TRIED)
        q, v = (np.outer(x.ravel(), shares) for x in (problem.q0, problem.v0))
        t: Any = problem.t0 + 1e-3 * np.arange(TRIED)
        first = self._each(self.function, (q[:, :1], v[:, :1]), t[:1])
        self._check(first, t[:1])
        try:
            own = computed(self.traceable, *self._entries(q, v, t), t.shape)[0]
        except Exception as error:  # whatever the function raises with entries
            self.refusal = f"{type(error).__name__}: {error}".rstrip(".")
            return
        with np.errstate(all="ignore"):
            rows = np.array([first[0], *self._each(self.function, (q[:, 1:], v[:, 1:]), t[1:])])
        if not np.allclose(own, rows, rtol=AGREES, atol=AGREES * np.max(np.abs(rows), initial=0.0)):
            self.refusal = "its values for many states are others"

    @property
    def traceable(self) -> Any:
        """The function, that of Python where it is compiled."""
        return getattr(self.function, "py_func", self.function)

    def many(self, q: Array, v: Array, t: Array) -> Array:
        """Values (*t.shape) at states, whose entries are in front: (r, *t.shape)."""
        if self.refusal:
            flat = q.reshape(len(q), -1), v.reshape(len(v), -1)
            found = self._each(self.function, flat, t.ravel()).reshape(t.shape)
        else:
            found = computed(self.traceable, *self._entries(q, v, t), t.shape)[0]
        self._check(found, t)
        return found

    def of(self, function: Any, q: Array, v: Array, t: Array) -> Array:
        """What another function makes of n states (n, ...)."""
        return self._each(function, (q.reshape(len(q), -1).T, v.reshape(len(v), -1).T), t)

    def bounds(self, q: Any, v: Any, t: Any, n: int) -> tuple[Array, Array]:
        """The least and the greatest value on n steps, from entries that are bounds."""
        return computed(self.traceable, q.reshape(self.shapes[0]), v.reshape(self.shapes[1]), t,
                        (n,))  # fmt: skip

    def _entries(self, q: Array, v: Array, t: Array) -> tuple[Any, Any, Entry]:
        return entries(q, self.shapes[0]), entries(v, self.shapes[1]), Entry(t, t)

    def _each(self, function: Any, states: tuple[Array, Array], t: Array) -> Array:
        """Values (n,) of states (r, n), one after another."""
        found = np.empty(len(t))
        for k, time in enumerate(t.tolist()):
            state = (x[:, k].reshape(shape) for x, shape in zip(states, self.shapes, strict=True))
            try:
                value = function(*state, time)
            except Exception as error:
                error.add_note(f"This was the event {self.name}, at t = {time!r}.")
                raise
            found[k] = input_checks.returned(f"the event {self.name}", value)
        return found

    def _check(self, values: Array, t: Array) -> None:
        wrong = np.flatnonzero(~np.isfinite(values.ravel()))
        if wrong.size:
            raise ValueError(
                f"the event {self.name} must be a finite number along the run; received "
                f"{values.ravel()[wrong[0]]} at t = {t.ravel()[wrong[0]]:.10g}."
            )
