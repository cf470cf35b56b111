"""What the rest of the package asks of a mechanical system with L = v.M v / 2 - V(q, t)."""

from __future__ import annotations

from typing import Protocol

from galvi.arrays import Array
from galvi.systems.field import Field


class System(Protocol):
    """A Lagrangian system; ``...`` are leading axes, ``shape`` the axes of one configuration."""

    def check(self, q: Array, v: Array) -> None:
        """Raise ValueError, in one sentence, when (q, v) cannot be a state of this system."""

    def momentum(self, v: Array) -> Array:
        """p = M v, for v of shape (..., *shape)."""

    def velocity(self, p: Array) -> Array:
        """v = M^-1 p, for p of shape (..., *shape)."""

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V(q, t) of shape (...), for q of shape (..., *shape) and t of shape (...)."""

    def acceleration(self, q: Array, t: float) -> Array:
        """M^-1 (-dV/dq) at one configuration, in its shape."""

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """d(acceleration)/dq at one configuration, shape (d, d) with d = q.size."""

    def field(self, dimension: int) -> Field:
        """The same as the kernels take it; ``dimension`` is the last axis of a configuration."""
