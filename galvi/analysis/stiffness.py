"""How strongly a problem's force changes with place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem

SHARE = 0.1  # of 1 / frequency: a step of the short trajectory
MOST, LEAST = 400, 20  # such steps
WORK = 4e7  # of d^3 of all steps together, d the number of components
PERIODS = 10.0 * np.pi  # radians of it, when no step tells a length


@dataclass(frozen=True)
class Stiffness:
    """Of V with L = v.M v / 2 - V, in the problem's units.

    lipschitz  K, the Lipschitz constant of dV/dq, a force over a length
    square     of the largest frequency, 1 / time^2: K over the least mass when K is given; when it
               is estimated, the largest absolute eigenvalue of M^-1/2 V'' M^-1/2, that is K in
               coordinates in which the mass is 1
    entries    H's C_R in such coordinates, the largest absolute second derivative of V
    dimension  D, the number of components
    source     where K is from, in words
    """

    lipschitz: float
    square: float
    entries: float
    dimension: int
    source: str

    @property
    def frequency(self) -> float:
        """Radians in the unit of time."""
        return float(np.sqrt(self.square))


def given(problem: Problem, lipschitz: float) -> Stiffness:
    """From the user's K; each second derivative of V is at most K."""
    least = float(np.linalg.eigvalsh(_mass(problem))[0])
    square = lipschitz / least
    return Stiffness(lipschitz, square, square, problem.q0.size, "given")


def estimated(problem: Problem, duration: float | None) -> Stiffness | None:
    """The largest along a short trajectory; None where V'' or the force is not finite.

    duration  to follow; five periods of the start's fastest vibration when None

    Velocity Verlet from the start in steps of a tenth of 1 / frequency there, at most 400 and for
    large systems fewer: the estimate is a lower bound, and the source says how far it went.
    """
    system: Any = problem.system
    d, q, v, t = problem.q0.size, problem.q0, problem.v0, problem.t0
    root: Array = np.asarray(np.linalg.cholesky(_mass(problem)), dtype=np.float64)
    most = int(np.clip(WORK / d**3, LEAST, MOST))
    left = np.inf if duration is None else abs(duration)
    largest = np.zeros(3)
    force: Array = system.acceleration(q, t)
    for _ in range(most):
        found = _sizes(system.acceleration_jacobian(q, t).reshape(d, d), root)
        if not np.all(np.isfinite(found)) or not np.all(np.isfinite(force)):
            return None
        largest = np.maximum(largest, found)
        if left == np.inf:
            left = PERIODS / np.sqrt(found[1]) if found[1] > 0.0 else 0.0
        if left <= 0.0:
            break
        dt = min(left, SHARE / np.sqrt(found[1])) if found[1] > 0.0 else left
        left -= dt
        half = v + 0.5 * dt * force
        q, t = q + dt * half, t + dt
        force = system.acceleration(q, t)
        v = half + 0.5 * dt * force
    source = f"estimated along the motion from t = {problem.t0:g} to {t:g}"
    lipschitz, square, entries = (float(x) for x in largest)
    return Stiffness(lipschitz, square, entries, d, source)


def _mass(problem: Problem) -> Array:
    """(d, d), from the momenta of unit velocities."""
    units = np.eye(problem.v0.size).reshape(-1, *problem.v0.shape)
    rows = [np.ravel(problem.system.momentum(unit)) for unit in units]
    return np.array(rows)


def _sizes(jacobian: Array, root: Array) -> Array:
    """|V''|, and the largest eigenvalue and entry of it with masses of 1; M = root root^T."""
    if not np.all(np.isfinite(jacobian)):
        return np.full(3, np.nan)
    hessian = -root @ (root.T @ jacobian)
    hessian = 0.5 * (hessian + hessian.T)
    weighted = np.linalg.solve(root, np.linalg.solve(root, hessian).T)
    norms = [np.max(np.abs(np.linalg.eigvalsh(matrix))) for matrix in (hessian, weighted)]
    return np.array([*norms, np.max(np.abs(weighted))])
