"""Interface of external forces that references recognise by their type and fields."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@runtime_checkable
class BuiltinForce(Protocol):
    """A callable f(q, v, t) of one configuration and velocity that has a compiled form."""

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        """f(q, v, t), shape of v."""

    @property
    def law(self) -> str:
        """The lines that define ``force``, a function (q, v, t, constants) -> d values in the
        functions of galvi.kernels.lanes.elementary; "" for none."""

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """Compiled function (q (r,), v (d,), t, constants, out (2, d)) that adds the force to the
        second row of out, and its constants."""
