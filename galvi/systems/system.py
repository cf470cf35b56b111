"""Interfaces of mechanical systems."""

from __future__ import annotations

from typing import Protocol

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.systems.force_kernel import ForceKernel
from galvi.systems.lagrangian_kernel import LagrangianKernel


class System(Protocol):
    """A Lagrangian system; ``...`` are leading axes, ``shape`` the axes of one configuration."""

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """Shape of velocities and momenta, from the shape of a configuration."""

    def check_state(self, q: Array, v: Array) -> None:
        """Raise ValueError, in one sentence, when (q, v) cannot be a state of this system."""

    def momentum(self, v: Array) -> Array:
        """p = M v, for v of shape (..., *shape)."""

    def velocity(self, p: Array) -> Array:
        """v = M^-1 p, for p of shape (..., *shape)."""


class VectorSystem(System, Protocol):
    """A system on a vector space, with L = v.M v / 2 - V(q, t)."""

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V(q, t) of shape (...), for q of shape (..., *shape) and t of shape (...)."""

    def acceleration(self, q: Array, t: float) -> Array:
        """M^-1 (-dV/dq) at one configuration, in its shape."""

    def acceleration_jacobian(self, q: Array, t: float) -> Array:
        """d(acceleration)/dq at one configuration, shape (d, d) with d = q.size."""

    def force_kernel(self, dimension: int) -> ForceKernel:
        """Force and derivative for the kernels; ``dimension`` is a configuration's last axis."""


class GroupSystem(System, Protocol):
    """A system on a Lie group: any regular Lagrangian, with an optional external force."""

    @property
    def group(self) -> Group:
        """The configuration space."""

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of the Lagrangian, and the external force, for the kernels."""
