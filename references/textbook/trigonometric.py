"""Trigonometric methods for stiff springs: mollified impulse, and an exponential integrator.

x'' = -Omega^2 x + g(x) in normal modes; with xi = h Omega and filters phi, psi_1 (Hairer, Lubich
and Wanner, Geometric Numerical Integration, XIII.2.2), g_n = g(phi x_n),

    x' = cos(xi) x + sin(xi) / Omega v + h^2 / 2 sinc(xi) psi_1 g_n
    v' = -Omega sin(xi) x + cos(xi) v + h / 2 psi_1 (cos(xi) g_n + g_(n+1))

One evaluation of the force a step, order 2, symmetric; symplectic where psi_1 = phi.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Canonical, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.contender import require
from references.newton import inverse_mass, is_forced, potential_force
from references.setting import check_keys, described, fixed_steps


@dataclass(frozen=True, eq=False)
class Trigonometric:
    """A trigonometric method with constant steps, interpreted; setting: step, save_every.

    stiffness  (d, d) symmetric: of the springs that are done exactly
    phi, kick  the filters phi and psi_1, functions of xi
    """

    name: str
    stiffness: Array
    phi: Callable[[Array], Array]
    kick: Callable[[Array], Array]
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Canonical system of as many coordinates as the stiffness, without external force."""
        fits = problem.q0.size == len(self.stiffness)
        return isinstance(problem.system, Canonical) and fits and not is_forced(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps. See `Contender`."""
        require(self, problem)
        check_keys(setting, ("step", "save_every"))
        steps = fixed_steps(duration, setting)
        times, h = steps.times(problem.t0), steps.step
        inverse, force = inverse_mass(problem), potential_force(problem)
        root = np.linalg.cholesky(inverse if inverse.ndim == 2 else np.diag(inverse))
        squares, U = np.linalg.eigh(root.T @ self.stiffness @ root)
        omega, F = np.sqrt(np.maximum(squares, 0.0)), root @ U
        xi = h * omega
        c, s, turned = np.cos(xi), h * np.sinc(xi / np.pi), -omega * np.sin(xi)
        phi, kick = self.phi(xi), self.kick(xi)
        place, back = 0.5 * h * s * kick, np.linalg.inv(F)
        x, v = back @ problem.q0, back @ problem.v0
        rest = np.zeros(x.size)

        def left(x: Array) -> Array:
            out = np.zeros(x.size)
            force.function(F @ (phi * x), rest, 0.0, force.numbers, out)
            pull: Array = F.T @ out + omega**2 * (phi * x)
            return pull

        g, kept = left(x), [(x, v)]
        saved = set(np.asarray(steps.saved).tolist())
        for number in range(1, steps.count + 1):
            later = c * x + s * v + place * g
            ahead = left(later)
            v = turned * x + c * v + 0.5 * h * kick * (c * g + ahead)
            x, g = later, ahead
            if number in saved:
                kept.append((x, v))
        q, p = (np.array([F @ pair[k] for pair in kept]) for k in range(2))
        counts = {"steps": steps.count, "force_evaluations": steps.count + 1}
        return as_trajectory(
            problem, described(self.name, setting), times, q, p, counts=counts, step=h
        )


def _sinc(xi: Array) -> Array:
    values: Array = np.sinc(xi / np.pi)
    return values


def mollified_impulse(stiffness: Array) -> Trigonometric:
    """Garcia-Archilla, Sanz-Serna and Skeel (1998): symplectic."""
    return Trigonometric("mollified impulse", stiffness, _sinc, _sinc)


def exponential_integrator(stiffness: Array) -> Trigonometric:
    """Grimm and Hochbruck (2006): psi = sinc^3; of order 2 uniformly in h omega."""
    return Trigonometric("exponential integrator", stiffness, _sinc, lambda xi: _sinc(xi) ** 2)
