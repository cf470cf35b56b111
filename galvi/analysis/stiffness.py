"""Estimates of the Lipschitz constant of a problem's force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem

SHARE = 0.1  # step of the short trajectory, times frequency
MOST, LEAST = 400, 20  # numbers of such steps
WORK = 4e7  # steps times d^3, d the number of components
PERIODS = 10.0 * np.pi  # phase covered when no step is given: five periods


@dataclass(frozen=True)
class Stiffness:
    """Bounds on the second derivatives of V, L = v.M v / 2 - V, in the problem's units.

    lipschitz  K, the Lipschitz constant of dV/dq, a force over a length
    square     largest frequency squared, 1 / time^2: K over the least mass when K is given; when it
               is estimated, the largest absolute eigenvalue of M^-1/2 V'' M^-1/2, that is K in
               coordinates in which the mass is 1
    entries    H's C_R in such coordinates, the largest absolute second derivative of V
    dimension  D, the number of components
    source     origin of K, in words
    """

    lipschitz: float
    square: float
    entries: float
    dimension: int
    source: str

    @property
    def frequency(self) -> float:
        """The largest frequency, in radians per unit of time."""
        return float(np.sqrt(self.square))


def given(problem: Problem, lipschitz: float) -> Stiffness:
    """From a given K, which bounds each second derivative of V."""
    least = float(np.linalg.eigvalsh(_mass(problem))[0])
    square = lipschitz / least
    return Stiffness(lipschitz, square, square, problem.q0.size, "given")


def estimated(problem: Problem, duration: float | None) -> tuple[Stiffness | None, str]:
    """The maximum along a short trajectory and "", or None and the reason.

    duration  length of the trajectory, negative for backwards; None: five periods of the fastest
              vibration at the start

    Velocity Verlet with steps of at most a tenth of 1 / frequency at both ends, at most 400 of them
    and fewer for large systems. The estimate is a lower bound; ``source`` gives the interval.
    """
    system: Any = problem.system
    d, q, v, t = problem.q0.size, problem.q0, problem.v0, problem.t0
    root: Array = np.asarray(np.linalg.cholesky(_mass(problem)), dtype=np.float64)
    force, found = _at(system, q, t, root)
    if duration is None and found[1] == 0.0:
        return None, (
            "the force does not change with position at the start, which gives no time scale for "
            "an estimate. Give a step, or lipschitz."
        )
    left = PERIODS / np.sqrt(found[1]) if duration is None else duration
    largest, most = found, _longest(found, left)
    for _ in range(int(np.clip(WORK / d**3, LEAST, MOST))):
        if not np.all(np.isfinite(found)) or not np.all(np.isfinite(force)):
            return None, "the force or its derivative is not finite near the start."
        largest = np.maximum(largest, found)
        if left == 0.0:
            break
        dt = most if abs(most) < abs(left) else left
        half = v + 0.5 * dt * force
        there = q + dt * half
        pull, ahead = _at(system, there, t + dt, root)
        if abs(dt) > 2.0 * abs(_longest(ahead, left)):
            most = 0.5 * _longest(ahead, left)
            continue
        q, t, force, found, v = there, t + dt, pull, ahead, half + 0.5 * dt * pull
        left, most = left - dt, _longest(found, left)
    source = f"estimated along the motion from t = {problem.t0:g} to {t:g}"
    lipschitz, square, entries = (float(x) for x in largest)
    return Stiffness(lipschitz, square, entries, d, source), ""


def _at(system: Any, q: Array, t: float, root: Array) -> tuple[Array, Array]:
    """The acceleration, in q's shape, and `_sizes` of its Jacobian."""
    jacobian = system.acceleration_jacobian(q, t).reshape(q.size, q.size)
    force: Array = system.acceleration(q, t)
    return force, _sizes(jacobian, root)


def _longest(found: Array, left: float) -> float:
    """The longest step for the sizes ``found``, with the sign of ``left``."""
    length = SHARE / np.sqrt(found[1]) if found[1] > 0.0 else abs(left)
    return float(np.copysign(length, left))


def _mass(problem: Problem) -> Array:
    """The mass matrix (d, d), from the momenta of unit velocities."""
    units = np.eye(problem.v0.size).reshape(-1, *problem.v0.shape)
    rows = [np.ravel(problem.system.momentum(unit)) for unit in units]
    return np.array(rows)


def _sizes(jacobian: Array, root: Array) -> Array:
    """(3,): |V''|, then |V''| and its largest entry for unit mass; M = root root^T."""
    if not np.all(np.isfinite(jacobian)):
        return np.full(3, np.nan)
    hessian = -root @ (root.T @ jacobian)
    hessian = 0.5 * (hessian + hessian.T)
    weighted = np.linalg.solve(root, np.linalg.solve(root, hessian).T)
    norms = [np.max(np.abs(np.linalg.eigvalsh(matrix))) for matrix in (hessian, weighted)]
    return np.array([*norms, np.max(np.abs(weighted))])
