"""The potential of one fixed centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import central_force
from galvi.systems.potentials.potential import Law


@dataclass(frozen=True)
class CentralForce:
    """V(q) = -mu / |q|, q of shape (2,) or (3,), the centre at the origin.

    mu  strength, length^3 / time^2 times mass; ValueError unless finite and positive
    """

    mu: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", input_checks.positive("mu", self.mu))

    def __call__(self, q: Array) -> float:
        return float(-self.mu / np.linalg.norm(q))

    def at_states(self, q: Array) -> Array:
        """V (k,) of k configurations (k, d)."""
        result: Array = -self.mu / np.linalg.norm(q, axis=1)
        return result

    def gradient(self, q: Array) -> Array:
        """mu q / |q|^3."""
        result: Array = self.mu * q / np.linalg.norm(q) ** 3
        return result

    def hessian(self, q: Array) -> Array:
        """mu (I - 3 q q^T / |q|^2) / |q|^3."""
        square = float(q @ q)
        return self.mu * (np.eye(q.size) - 3.0 * np.outer(q, q) / square) / square**1.5

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
        return Law(central_force.gradient, central_force.hessian, np.array([self.mu]))
