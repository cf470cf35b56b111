"""A Lagrangian that brings its derivatives: a value with readable fields, callable as any other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@runtime_checkable
class BuiltinLagrangian(Protocol):
    """L of one configuration and velocity, and of the time where it has one."""

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        """L(q, v) or L(q, v, t)."""

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and the Euclidean dL/dq in one vector, (d + entries of q,)."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """law(q, v, t, constants, out (2, d)) with rows dL/dv and dL/dq, compiled, and its
        constants."""
