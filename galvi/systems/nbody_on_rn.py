"""Point masses on the group R^d, where forces may depend on velocities."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Rn
from galvi.kernels.forces import celestial, celestial_velocity, lagrangian_derivatives
from galvi.systems.nbody import NBody
from galvi.systems.system import LagrangianKernel


@dataclass(frozen=True)
class NBodyOnRn:
    """L = sum m |v|^2 / 2 - V(q), V that of gravity and of forces of position, with other forces.

    Attributes
    ----------
    bodies
        the system
    dimension
        2 or 3
    """

    bodies: NBody
    dimension: int

    @cached_property
    def group(self) -> Rn:
        """R^d of all coordinates."""
        return Rn(self.bodies.masses.size * self.dimension)

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """The shape of a configuration."""
        return shape

    def check_state(self, q: Array, v: Array, t: float) -> None:
        """Raise ValueError as `NBody.check_state`."""
        q, v = (x.reshape(-1, self.dimension) for x in (q, v))
        self.bodies.check_state(q, v, t)

    def momentum(self, v: Array) -> Array:
        """p = m v, v of shape (..., d)."""
        return np.repeat(self.bodies.masses, self.dimension) * v

    def velocity(self, p: Array) -> Array:
        """v = p / m, p of shape (..., d)."""
        return p / np.repeat(self.bodies.masses, self.dimension)

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels."""
        acting, D = self.bodies.acting, self.dimension
        constants = np.concatenate([np.repeat(self.bodies.masses, D), acting.constants(D)])
        kernel = LagrangianKernel(
            lagrangian_derivatives.LAW, celestial.lagrangian, constants=constants
        )
        if not acting.functions:
            return replace(
                kernel,
                force_kind=lagrangian_derivatives.FORCE_LAW,
                force=celestial_velocity.add_forces,
                force_constants=acting.velocity_constants(D),
            )
        return replace(
            kernel,
            force_kind=lagrangian_derivatives.TIMED_FORCE,
            force=acting.force(D),
            compiled=acting.compiled,
        )
