"""The textbook's equations of a chain of links in a plane, apart from galvi's Lagrangian.

The centre of link k is at x = sum_i S_ki sin q_i, z = -sum_i S_ki cos q_i, with S_ki = l_i above
the link, its own lever at i = k, and 0 below. With J = dx/dq, K = dz/dq, masses m and moments I
about the centres, d'Alembert's principle is

    (J' m J + K' m K + I) q'' = J' m S (sin q v^2) - K' m S (cos q v^2) - g K' m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Lagrangian, PlanarChain, Problem
from galvi.arrays import Array
from references.newton import is_forced


@dataclass(frozen=True, eq=False)
class ChainEquations:
    """The equations of motion of a chain of n links.

    masses   (n,)
    moments  (n,) of inertia about the centres of mass
    levers   S (n, n)
    gravity  acceleration, downwards
    """

    masses: Array
    moments: Array
    levers: Array
    gravity: float

    @staticmethod
    def of(chain: PlanarChain, number: Any = np.float64) -> ChainEquations:
        """From a PlanarChain, computed with numbers of this type."""
        m, l = (np.array([number(float(x)) for x in row]) for row in (chain.masses, chain.lengths))
        n = len(m)
        S = np.array([[l[i] if i <= k else number(0.0) for i in range(n)] for k in range(n)])
        moments = number(0.0) * m
        if chain.rods:
            S[np.diag_indices(n)] = number(0.5) * l
            moments = m * l * l / number(12.0)
        return ChainEquations(m, moments, S, number(float(chain.gravity)))

    def mass(self, q: Array) -> Array:
        """The mass matrix (n, n) at q (n,)."""
        J, K = self.levers * np.cos(q), self.levers * np.sin(q)
        return J.T * self.masses @ J + K.T * self.masses @ K + np.diag(self.moments)

    def acceleration(self, q: Array, v: Array) -> Array:
        """q'' (n,) at q and v, (n,) each."""
        J, K = self.levers * np.cos(q), self.levers * np.sin(q)
        pull = J.T @ (self.masses * (K @ v**2)) - K.T @ (self.masses * (J @ v**2))
        weight = self.gravity * (K.T @ self.masses)
        return np.linalg.solve(self.mass(q), pull - weight)


def is_chain(problem: Problem) -> bool:
    """Whether the system is a PlanarChain with its own slopes and no external force."""
    system = problem.system
    return (
        isinstance(system, Lagrangian)
        and isinstance(system.function, PlanarChain)
        and system.slopes is None
        and not is_forced(problem)
    )
