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
    slopes     the lines that define dV/dq for lanes, see galvi.symbolic.lane_force; "" for none
    """

    gradient: Callable[..., Any]
    hessian: Callable[..., Any]
    constants: Array
    slopes: str = ""


def lane_slopes(name: str) -> str:
    """The lines that import the slopes of a built-in potential."""
    return f"from galvi.kernels.lanes.potentials import {name} as slopes"


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
