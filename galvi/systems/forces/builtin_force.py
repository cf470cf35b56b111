"""An external force that references recognise: a value with readable fields, callable as any."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@runtime_checkable
class BuiltinForce(Protocol):
    """f(q, v, t) of one configuration and velocity, whose numbers the kernels take as such."""

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        """f(q, v, t), shape of v."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """add(g (r,), v (d,), t, constants, out (2, d)), which adds the force to the second row of
        out, compiled; and the constants it needs."""
