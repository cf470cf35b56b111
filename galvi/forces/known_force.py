"""An external force that references recognise: a value with readable fields, callable as any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class Push:
    """A force as a compiled function.

    add        (g (r,), v (d,), t, constants, out (2, d)) adds the force to the second row of out
    constants  the numbers it needs
    """

    add: Callable[..., Any]
    constants: Array


@runtime_checkable
class KnownForce(Protocol):
    """f(q, v, t) of one configuration and velocity, whose numbers the kernels take as such."""

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        """f(q, v, t), shape of v."""

    def push(self) -> Push:
        """The same for the kernels."""
