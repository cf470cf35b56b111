"""The gravitational potential of plane pendulums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import pendulum
from galvi.systems.potentials.potential import Law


@dataclass(frozen=True)
class CosinePotential:
    """V(q) = -weight sum cos(q_i), q of shape (d,): d pendulums, angles from hanging down.

    weight  m g l, an energy; ValueError unless finite and positive
    """

    weight: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "weight", input_checks.positive("weight", self.weight))

    def __call__(self, q: Array) -> float:
        return float(-self.weight * np.sum(np.cos(q)))

    def at_states(self, q: Array) -> Array:
        """V (k,) of k configurations (k, d)."""
        result: Array = -self.weight * np.sum(np.cos(q), axis=1)
        return result

    def gradient(self, q: Array) -> Array:
        """weight sin(q_i)."""
        result: Array = self.weight * np.sin(q)
        return result

    def hessian(self, q: Array) -> Array:
        """weight cos(q_i) on the diagonal."""
        return np.diag(self.weight * np.cos(q))

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
        return Law(pendulum.gradient, pendulum.hessian, np.array([self.weight]))
