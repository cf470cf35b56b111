"""The potential of a chain of nonlinear springs between two walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import spring_chain
from galvi.systems.potentials.potential import Law


@dataclass(frozen=True)
class SpringChain:
    """V(q) = sum over springs of r^2/2 + alpha r^3/3 + beta r^4/4, q of shape (d,) displacements.

    alpha, beta  quadratic and cubic stiffness; ValueError unless finite

    Fermi, Pasta, Ulam and Tsingou, Los Alamos report LA-1940 (1955), eqs. 1 and 2.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", input_checks.real("alpha", self.alpha))
        object.__setattr__(self, "beta", input_checks.real("beta", self.beta))

    def __call__(self, q: Array) -> float:
        r = np.diff(q, prepend=0.0, append=0.0)
        return float(np.sum(r**2 / 2.0 + self.alpha * r**3 / 3.0 + self.beta * r**4 / 4.0))

    def at_states(self, q: Array) -> Array:
        """V (k,) of k configurations (k, d)."""
        r = np.diff(q, axis=1, prepend=0.0, append=0.0)
        result: Array = np.sum(
            r**2 / 2.0 + self.alpha * r**3 / 3.0 + self.beta * r**4 / 4.0, axis=1
        )
        return result

    def gradient(self, q: Array) -> Array:
        """dV/dq, (d,)."""
        out = np.empty((q.size, 1))
        law = self.law()
        law.gradient(np.ascontiguousarray(q)[:, None], np.zeros(1), law.constants, out)
        return out[:, 0]

    def hessian(self, q: Array) -> Array:
        """d2V/dq2, (d, d)."""
        out = np.empty((q.size, q.size, 1))
        law = self.law()
        law.hessian(np.ascontiguousarray(q)[:, None], np.zeros(1), law.constants, out)
        return out[:, :, 0]

    def law(self) -> Law:
        """Compiled derivatives and their constants."""
        return Law(spring_chain.gradient, spring_chain.hessian, np.array([self.alpha, self.beta]))
