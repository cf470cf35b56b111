"""The potential of a constant force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import uniform_field
from galvi.systems.potentials.potential import Law


@dataclass(frozen=True, eq=False)
class UniformField:
    """V(q) = -force . q, e.g. of a weight, with force = mass g.

    force  (d,) as q; ValueError unless finite
    """

    force: Any

    def __post_init__(self) -> None:
        force = input_checks.array("force", self.force)
        if force.ndim != 1:
            raise ValueError(f"force must have shape (d,); received shape {force.shape}.")
        object.__setattr__(self, "force", force)

    def __call__(self, q: Array) -> float:
        return float(-(self.force @ q))

    def at_states(self, q: Array) -> Array:
        """V (k,) of k configurations (k, d)."""
        return -(q @ self.force)

    def gradient(self, q: Array) -> Array:
        """-force."""
        return -self.force + 0.0 * q

    def hessian(self, q: Array) -> Array:
        """0."""
        return np.zeros((q.size, q.size))

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
        return Law(uniform_field.gradient, uniform_field.hessian, np.array(self.force))
