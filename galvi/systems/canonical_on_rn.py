"""A canonical system on the group R^d, for external forces and degrees for each component."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Rn
from galvi.kernels.forces import force_kinds, lagrangian_derivatives
from galvi.systems.canonical import Canonical
from galvi.systems.forces.external_force import with_force
from galvi.systems.system import LagrangianKernel


@dataclass(frozen=True)
class CanonicalOnRn:
    """L = v.M v / 2 - V(q, t) with an external force, or with degrees for each component.

    Attributes
    ----------
    canonical
        the system
    group
        Rn(d)
    """

    canonical: Canonical
    group: Rn

    def velocity_shape(self, shape: tuple[int, ...]) -> tuple[int, ...]:
        return self.canonical.velocity_shape(shape)

    def check_state(self, q: Array, v: Array, t: float) -> None:
        self.canonical.check_state(q, v, t)

    def momentum(self, v: Array) -> Array:
        """p = M v, v of shape (..., d)."""
        return self.canonical.momentum(v)

    def velocity(self, p: Array) -> Array:
        """v = M^-1 p, p of shape (..., d)."""
        return self.canonical.velocity(p)

    @property
    def potential_calls_per_force(self) -> int:
        return self.canonical.potential_calls_per_force

    def lagrangian_kernel(self) -> LagrangianKernel:
        """Derivatives of L for the kernels; constants: M by rows, then those of the potential."""
        d = self.group.dimension
        field = self.canonical.force_kernel(d)
        built_in = field.kind == force_kinds.BUILT_IN
        mass = self.canonical.momentum(np.eye(d))
        kernel = LagrangianKernel(
            lagrangian_derivatives.CANONICAL
            if built_in
            else lagrangian_derivatives.CANONICAL_GRADIENT,
            field.force,
            time_dependent=field.kind == force_kinds.TIMED_GRADIENT,
            constants=np.concatenate([mass.ravel(), field.constants]),
            compiled=field.compiled,
        )
        return with_force(kernel, self.canonical, 0)


def checked_degrees(space: Any, system: Any, components: int) -> tuple[int, ...] | None:
    """The degree of each component; None for a space with a single degree.

    Parameters
    ----------
    components
        number of components of a velocity of the system

    Raises
    ------
    ValueError
        When the numbers of degrees and components differ, and for an NBody system.
    """
    degrees: tuple[int, ...] | None = getattr(space, "degrees", None)
    if degrees is None:
        return None
    if len(degrees) != components:
        raise ValueError(
            f"the space must have a degree for each of the {components} components; received "
            f"{len(degrees)} degrees, {degrees}."
        )
    if not (hasattr(system, "group") or isinstance(system, Canonical)):
        raise ValueError(
            f"degrees for each component are for Canonical and Lagrangian systems; received a "
            f"{type(system).__name__} system. Use galvi.Polynomials."
        )
    return degrees
