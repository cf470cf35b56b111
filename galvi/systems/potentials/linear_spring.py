"""The potential of a linear spring to the origin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import linear_spring
from galvi.systems.potentials.potential import Law


@dataclass(frozen=True)
class LinearSpring:
    """V(q) = stiffness |q|^2 / 2, q of shape (d,).

    stiffness  force per length; ValueError unless finite and positive
    """

    stiffness: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", input_checks.positive("stiffness", self.stiffness))

    def __call__(self, q: Array) -> float:
        return float(0.5 * self.stiffness * (q @ q))

    def at_states(self, q: Array) -> Array:
        """V (k,) of k configurations (k, d)."""
        result: Array = 0.5 * self.stiffness * np.sum(q * q, axis=1)
        return result

    def gradient(self, q: Array) -> Array:
        """stiffness q."""
        return self.stiffness * q

    def hessian(self, q: Array) -> Array:
        """stiffness I."""
        return self.stiffness * np.eye(q.size)

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
        return Law(linear_spring.gradient, linear_spring.hessian, np.array([self.stiffness]))
