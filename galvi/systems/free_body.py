"""A rigid body that rotates and translates, on SE(3)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.se3 import SE3
from galvi.kernels.forces import lagrangian_derivatives
from galvi.symbolic import lane_law
from galvi.systems.lagrangian_kernel import LagrangianKernel
from galvi.systems.rigid_body import inverse, possible_inertia


@dataclass(frozen=True, eq=False)
class FreeBody:
    """L = w . J w / 2 + mass |v|^2 / 2 + mass g . x for the rigid motion [[R, x], [0, 1]].

    mass     positive
    inertia  J about the centre of mass x, in the body's frame: (3,) principal moments or (3, 3)
    g        (3,) acceleration of gravity in space

    Configurations are (4, 4); velocities (6,) are (w, v), both in the body's frame, and momenta
    p = (J w, mass v). Raises ValueError for a mass or an inertia that no body can have.
    """

    mass: float
    inertia: Any
    g: Any = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", input_checks.positive("mass", self.mass))
        object.__setattr__(self, "inertia", possible_inertia(self.inertia))
        object.__setattr__(self, "g", input_checks.array("g", self.g, (3,)))

    def __reduce__(self) -> tuple[Any, ...]:
        return FreeBody, (self.mass, self.inertia, self.g)

    @property
    def group(self) -> SE3:
        """The configuration space, SE(3)."""
        return SE3()

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        """(6,): angular velocity, then velocity, in the body's frame."""
        return (6,)

    def check_state(self, q: Array, v: Array) -> None:
        """ValueError unless q is a rigid motion."""
        self.group.check("q0", q)

    def momentum(self, v: Array) -> Array:
        """p = (J w, mass v), v of shape (..., 6)."""
        return np.concatenate([v[..., :3] @ self.inertia, self.mass * v[..., 3:]], axis=-1)

    def velocity(self, p: Array) -> Array:
        """v = (J^-1 p_w, p_v / mass), p of shape (..., 6)."""
        return np.concatenate([p[..., :3] @ self._inverse, p[..., 3:] / self.mass], axis=-1)

    @cached_property
    def _inverse(self) -> Array:
        return inverse(self.inertia)

    def potential_energy(self, q: Array, t: Array) -> Array:
        """V = -mass g . x, (...), for q of shape (..., 4, 4)."""
        result: Array = -self.mass * (q[..., :3, 3] @ self.g)
        return result

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels; constants: J by rows, mass, g."""
        constants = np.concatenate([self.inertia.ravel(), [self.mass], self.g])
        return LagrangianKernel(
            lagrangian_derivatives.LAW, lagrangian_derivatives.free_body, constants=constants
        )

    @property
    def lane_law(self) -> tuple[str, Array]:
        """The lines and constants of its law for lanes, see galvi.symbolic.lane_law."""
        law = lane_law.built_in("free_body", bool(np.any(self.g)))
        return law, self.lagrangian_kernel().constants
