"""A Lagrangian that brings its derivatives: a value with readable fields, callable as any other."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array
from galvi.systems.group_field import GroupField


@runtime_checkable
class KnownLagrangian(Protocol):
    """L of one configuration and velocity, and of the time where it has one."""

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        """L(q, v) or L(q, v, t)."""

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and the Euclidean dL/dq in one vector, (d + entries of q,)."""

    def group_field(self) -> GroupField:
        """The same for the kernels."""
