"""The second variation of the action along one step with fixed end points (H 3.3.2).

In a chart at R0, xi(t) is the step's curve and l(xi, xi') = T - V along it, by textbook formulas;
its second derivatives are central differences of complex-step first derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigvalsh, null_space

import galvi
from galvi import Trajectory
from galvi.arrays import Array

NUDGE = 1e-4
COMPLEX_STEP = 1e-30
CURVE_POINTS = 40  # points of the curve at which the constants are maximised


@dataclass(frozen=True)
class Constants:
    """H's constants for L = v . J v / 2 - V (H's kinetic energy lacks the trace and the half).

    Attributes
    ----------
    speed
        C_xi' = C_p / 2, C_p the least eigenvalue of d2T/dxi'2
    displacement
        C_xi = C_d + C_m^2 / (2 C_p), C_m twice the norm of d2T/dxi dxi', -C_d the least eigenvalue
        of d2T/dxi2 (0 where that is positive)
    well
        C_V, the largest eigenvalue of d2V/dxi2 (0 where that is negative)
    """

    speed: float
    displacement: float
    well: float

    @property
    def minimum(self) -> float:
        """The step below which the proof of H 3.3.1 gives a minimum; its statement omits it."""
        return float(np.pi * np.sqrt(self.speed / (self.displacement + self.well)))

    @property
    def coercive(self) -> float:
        """The step of H 3.3.2, below which the second variation is coercive."""
        return float(np.pi * np.sqrt(0.5 * self.speed / (self.displacement + self.well)))


def constants(run: Trajectory) -> Constants:
    """H's constants, as extremes along the curve of a run of one step."""
    xi, eta = _curve(run, np.linspace(0.0, 1.0, CURVE_POINTS))
    kinetic, potential = _seconds(_kinetic, run, xi, eta), _seconds(_potential, run, xi, eta)
    least_eigenvalue = float(np.min(np.linalg.eigvalsh(kinetic[:, 3:, 3:])))
    mixed = 2.0 * float(np.max(np.linalg.norm(kinetic[:, :3, 3:], ord=2, axis=(1, 2))))
    down = max(0.0, -float(np.min(np.linalg.eigvalsh(kinetic[:, :3, :3]))))
    well = max(0.0, float(np.max(np.linalg.eigvalsh(potential[:, :3, :3]))))
    return Constants(0.5 * least_eigenvalue, down + 0.5 * mixed**2 / least_eigenvalue, well)


def smallest(run: Trajectory) -> float:
    """The least eigenvalue of the discrete second variation against the integral of |dxi'|^2."""
    A, _, rates, weights = _discrete(run)
    return float(eigvalsh(A, _gram(rates, weights), subset_by_index=[0, 0])[0])


def over_lower_form(run: Trajectory, step_constants: Constants) -> float:
    """The least of D2S over H (3.30)-(3.31), C_xi' / 2 |dxi'|^2 + (C_xi' pi^2 / (2 h^2) - C_xi -
    C_V) |dxi|^2 integrated; at least 1 where H's estimate is one. NaN past the coercive step."""
    h = run.t[1] - run.t[0]
    A, inside, rates, weights = _discrete(run)
    level = (
        0.5 * step_constants.speed * (np.pi / h) ** 2
        - step_constants.displacement
        - step_constants.well
    )
    if level < 0.0:
        return float("nan")
    lower = 0.5 * step_constants.speed * _gram(rates, weights) + level * _gram(inside, weights)
    return float(eigvalsh(A, lower, subset_by_index=[0, 0])[0])


def _discrete(run: Trajectory) -> tuple[Array, Array, Array, Array]:
    """D2S of the step, and the values and rates of variations at the stages, with their weights."""
    table: Any = run.method.table
    h = run.t[1] - run.t[0]
    free = null_space(table.end[None, :])
    inside, rates = table.psi @ free, table.slope @ free / h
    xi, eta = _at(run, table.psi, table.slope)
    second = _seconds(_kinetic, run, xi, eta) - _seconds(_potential, run, xi, eta)
    weights = h * table.b
    size = 3 * free.shape[1]
    A = np.zeros((size, size))
    for j, weight in enumerate(weights):
        variations = np.vstack([np.kron(inside[j], np.eye(3)), np.kron(rates[j], np.eye(3))])
        A += weight * variations.T @ second[j] @ variations
    return A, inside, rates, weights


def _gram(values: Array, weights: Array) -> Array:
    return np.kron(values.T @ (weights[:, None] * values), np.eye(3))


def _curve(run: Trajectory, tau: Array) -> tuple[Array, Array]:
    """xi and xi', (k, 3) each, at fractions tau (k,) of the step."""
    space: Any = run.method.space
    psi = (space.basis(tau) - space.basis(np.zeros(1)))[:, 1:]
    return _at(run, psi, space.derivative(tau)[:, 1:])


def _at(run: Trajectory, psi: Array, slope: Array) -> tuple[Array, Array]:
    x = run.curves.coefficients[0]
    return psi @ x.T, slope @ x.T / (run.t[1] - run.t[0])


def _seconds(function: Any, run: Trajectory, xi: Array, eta: Array) -> Array:
    """Second derivatives (k, 6, 6) by (xi, xi') at k points, (k, 3) each."""
    z = np.concatenate([xi, eta], axis=1).astype(complex)
    hessians = np.empty((len(z), 6, 6))
    for i in range(6):
        for j in range(6):
            ahead, behind = z.copy(), z.copy()
            ahead[:, i] += NUDGE
            behind[:, i] -= NUDGE
            ahead[:, j] += 1j * COMPLEX_STEP
            behind[:, j] += 1j * COMPLEX_STEP
            change = function(run, ahead).imag - function(run, behind).imag
            hessians[:, i, j] = change / (2.0 * NUDGE * COMPLEX_STEP)
    return 0.5 * (hessians + np.swapaxes(hessians, 1, 2))


def _kinetic(run: Trajectory, z: Array) -> Array:
    """v . J v / 2, v = T(xi) xi'."""
    xi, eta = z[:, :3], z[:, 3:]
    once = np.cross(xi, eta)
    square = np.sum(xi * xi, axis=1)[:, None]
    if isinstance(run.method.chart, galvi.Cayley):
        v = (eta - 0.5 * once) / (1.0 + 0.25 * square)
    else:
        first, second = _turned(square)[1:]
        v = eta - first * once + second * np.cross(xi, once)
    J = run.problem.system.inertia
    return 0.5 * np.sum(v * (v @ J), axis=1)


def _potential(run: Trajectory, z: Array) -> Array:
    """-m g . R0 Phi(xi) centre."""
    gravity = run.problem.system.potential
    if gravity is None:
        return np.zeros(len(z), dtype=complex)
    xi, centre = z[:, :3], np.broadcast_to(gravity.centre, (len(z), 3))
    once = np.cross(xi, centre)
    square = np.sum(xi * xi, axis=1)[:, None]
    if isinstance(run.method.chart, galvi.Cayley):
        turned = centre + (once + 0.5 * np.cross(xi, once)) / (1.0 + 0.25 * square)
    else:
        zeroth, first, _ = _turned(square)
        turned = centre + zeroth * once + first * np.cross(xi, once)
    return -turned @ (run.problem.q0.T @ (gravity.mass * gravity.g))


def _turned(square: Array) -> tuple[Array, Array, Array]:
    """sin a / a, (1 - cos a) / a^2 and (a - sin a) / a^3 of a^2, by series near 0."""
    small = np.abs(square) < 1e-2
    a = np.sqrt(np.where(small, 1.0, square))
    closed_forms = np.sin(a) / a, (1.0 - np.cos(a)) / a**2, (a - np.sin(a)) / a**3
    series = (
        1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))),
        0.5 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))),
        (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))) / 6.0,
    )
    return tuple(np.where(small, s, f) for s, f in zip(series, closed_forms, strict=True))
