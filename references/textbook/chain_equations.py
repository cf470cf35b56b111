"""Textbook equations of a chain of links in a plane, independent of galvi's Lagrangian.

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
from references.forces.force import agrees, points_around
from references.newton import is_forced


@dataclass(frozen=True, eq=False)
class ChainEquations:
    """The equations of motion of a chain of n links.

    Attributes
    ----------
    masses : array, shape (n,)
    moments : array, shape (n,)
        of inertia about the centres of mass
    levers : array, shape (n, n)
        S
    gravity
        downward acceleration
    """

    masses: Array
    moments: Array
    levers: Array
    gravity: float

    @staticmethod
    def of(chain: PlanarChain, number: Any = np.float64) -> ChainEquations:
        """The equations of a PlanarChain, computed with numbers of the type ``number``."""
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

    def acceleration(self, q: Array, v: Array, force: Any = 0.0) -> Array:
        """q'' (n,) at q and v, (n,) each, with an external force (n,)."""
        J, K = self.levers * np.cos(q), self.levers * np.sin(q)
        pull = J.T @ (self.masses * (K @ v**2)) - K.T @ (self.masses * (J @ v**2))
        weight = self.gravity * (K.T @ self.masses)
        return np.linalg.solve(self.mass(q), pull - weight + force)


def is_chain(problem: Problem, forced: bool = False) -> bool:
    """Whether the system is a PlanarChain whose slopes, if the user gives some, agree with the
    chain's at the start and around it; with an external force only if ``forced``."""
    system = problem.system
    if not isinstance(system, Lagrangian) or not isinstance(system.function, PlanarChain):
        return False
    return (forced or not is_forced(problem)) and (
        system.slopes is None or _own_slopes(system, problem)
    )


def _own_slopes(system: Lagrangian, problem: Problem) -> bool:
    equations, n = ChainEquations.of(system.function), problem.q0.size

    def chain_slopes(state: Array) -> Array:
        q, v = state[:n], state[n:]
        J, K = equations.levers * np.cos(q), equations.levers * np.sin(q)
        x, z = equations.masses * (J @ v), equations.masses * (K @ v)
        by_q = (J.T @ z - K.T @ x) * v - equations.gravity * (K.T @ equations.masses)
        return np.concatenate([equations.mass(q) @ v, by_q])

    def supplied_slopes(state: Array) -> Any:
        time = (problem.t0,) if system.explicit_time else ()
        assert system.slopes is not None
        return system.slopes(state[:n].copy(), state[n:].copy(), *time)

    start = np.concatenate([problem.q0, problem.v0])
    return agrees(supplied_slopes, chain_slopes, points_around(start))
