"""Interface of potentials that references recognise by their type and fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class Law:
    """Derivatives of a potential as compiled functions of all s stages at once.

    gradient   (Q (d, s), t (s,), constants, out (d, s)) fills out with dV/dq
    hessian    (Q (d, s), t (s,), constants, out (d, d, s)) fills out with d2V/dq2
    constants  (c,) constants of both functions
    lanes      name of dV/dq in galvi.kernels.lanes.potentials, of the same constants; "" for none
    """

    gradient: Callable[..., Any]
    hessian: Callable[..., Any]
    constants: Array
    lanes: str = ""


@runtime_checkable
class Potential(Protocol):
    """V(q) of configurations of shape (..., d), with its derivatives at one of them."""

    def __call__(self, q: Array) -> Array:
        """V(q), (...)."""

    def gradient(self, q: Array) -> Array:
        """dV/dq, shape (d,)."""

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, shape (d, d)."""

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
