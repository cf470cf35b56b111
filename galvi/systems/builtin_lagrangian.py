"""Interface of Lagrangians that come with their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@runtime_checkable
class BuiltinLagrangian(Protocol):
    """A callable L(q, v) or L(q, v, t) with analytic derivatives, also compiled."""

    def __call__(self, q: Array, v: Array, *t: Any) -> float:
        """L(q, v) or L(q, v, t)."""

    def slopes(self, q: Array, v: Array, *t: Any) -> Array:
        """dL/dv and the Euclidean dL/dq in one vector, (d + entries of q,)."""

    def at_states(self, q: Array, v: Array, t: Array) -> tuple[Array, Array, Array]:
        """L(q, v) and L(q, 0) (n,) each, and dL/dv (n, d), at n states; q and v (n, d), t (n,)."""

    @property
    def law(self) -> str:
        """The lines that define ``law``, a law of galvi.kernels.lanes.elementary with the constants
        of ``compiled``; "" for none."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q, v, t, constants, out (2, d)) that fills the rows dL/dv and dL/dq,
        and its constants."""


@runtime_checkable
class KnownMass(BuiltinLagrangian, Protocol):
    """A `BuiltinLagrangian` of a mass that depends on the configuration alone."""

    def mass(self, q: Array) -> Array:
        """d2L/dv2 (d, d) at one configuration."""
