"""Energies and momenta by textbook formulas, from positions and velocities or momenta."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import (
    Canonical,
    CentralForce,
    CosinePotential,
    FreeBody,
    LinearSpring,
    NBody,
    Problem,
    RigidBody,
    UniformGravity,
)
from galvi.arrays import Array
from references.closed_forms.double_double import DoubleDouble

# Energy and angular momentum by textbook formulas, term by term.
#
# Conservation by a run is measured with these, independently of galvi's own functions. q and v have
# shape (k, ...), results (k,) or (k, 3); for rigid bodies, q are rotations or rigid motions and v
# the body velocities.


def energy(problem: Problem, q: Array, v: Array) -> Array:
    """Kinetic plus potential energy, (k,). TypeError for a system without a formula here."""
    system = problem.system
    if isinstance(system, NBody):
        total = np.zeros(len(q))
        for i, mass in enumerate(system.masses):
            total += 0.5 * mass * np.sum(v[:, i] ** 2, axis=-1)
            for j in range(i):
                distance = np.sqrt(np.sum((q[:, i] - q[:, j]) ** 2, axis=-1))
                total -= system.G * mass * system.masses[j] / distance
        return total
    if isinstance(system, RigidBody):
        return _rotation_energy(system, v) + _height_energy(system.potential, q)
    if isinstance(system, FreeBody) and system.potential is None:
        translation = 0.5 * system.mass * np.sum(v[:, 3:] ** 2, axis=-1)
        for axis in range(3):
            translation -= system.mass * system.g[axis] * q[:, axis, 3]
        return _rotation_energy(system, v) + translation
    kinetic = 0.5 * _mass(problem) * np.sum(v**2, axis=-1)
    potential = system.potential if isinstance(system, Canonical) else None
    if isinstance(potential, LinearSpring):
        return kinetic + 0.5 * potential.stiffness * np.sum(q**2, axis=-1)
    if isinstance(potential, CentralForce):
        return kinetic - potential.mu / np.sqrt(np.sum(q**2, axis=-1))
    if isinstance(potential, CosinePotential):
        return kinetic - potential.weight * np.sum(np.cos(q), axis=-1)
    raise TypeError(f"there is no textbook energy here for {system!r}.")


def angular_momentum(problem: Problem, q: Array, v: Array) -> Array:
    """Sum of m q x v, (k,) in the plane and (k, 3) in space; R J v for a rigid body.

    TypeError for a system without a scalar mass that is neither.
    """
    system = problem.system
    if isinstance(system, RigidBody):
        return np.stack([_along(q[:, axis], v, system.inertia) for axis in range(3)], axis=-1)
    if isinstance(system, NBody):
        total = [m * _cross(q[:, i], v[:, i]) for i, m in enumerate(system.masses)]
        return np.sum(total, axis=0)
    return _mass(problem) * _cross(q, v)


def _cross(q: Array, v: Array) -> Array:
    if q.shape[-1] == 2:
        return q[..., 0] * v[..., 1] - q[..., 1] * v[..., 0]
    x, y, z = q[..., 0], q[..., 1], q[..., 2]
    a, b, c = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([y * c - z * b, z * a - x * c, x * b - y * a], axis=-1)


def _rotation_energy(system: RigidBody | FreeBody, v: Array) -> Array:
    """Half the sum of v_i J_ij v_j."""
    total = np.zeros(len(v))
    for i in range(3):
        for j in range(3):
            total += 0.5 * v[:, i] * system.inertia[i, j] * v[:, j]
    return total


def _height_energy(potential: object, q: Array) -> Array:
    """Minus the weight times the downward displacement of the centre of mass."""
    total = np.zeros(len(q))
    if potential is None:
        return total
    if not isinstance(potential, UniformGravity):
        raise TypeError(f"there is no textbook energy here for {potential!r}.")
    for i in range(3):
        for j in range(3):
            total -= potential.mass * potential.g[i] * q[:, i, j] * potential.centre[j]
    return total


def _along(row: Array, v: Array, inertia: Array) -> Array:
    """One spatial component of the momentum J v, by the corresponding row of R."""
    total = np.zeros(len(v))
    for i in range(3):
        for j in range(3):
            total += row[:, i] * inertia[i, j] * v[:, j]
    return total


def _mass(problem: Problem) -> float:
    mass = problem.system.mass if isinstance(problem.system, Canonical) else np.zeros(2)
    if mass.ndim:
        raise TypeError("the textbook formulas here are for a scalar mass.")
    return float(mass)


# Energies as functions of q and p, (k, ...) each, by textbook formulas; results (k,).
#
# Conservation by a contender is measured with these, independently of galvi's own functions.


def hamiltonian(problem: Problem, q: Array, p: Array) -> Array:
    """The energy of `energy` as a function of momenta, (k,)."""
    return energy(problem, q, problem.system.velocity(p))


def henon_heiles(problem: Problem, q: Array, p: Array) -> Array:
    """p^2 / 2 + (x^2 + y^2) / 2 + x^2 y - y^3 / 3 for unit mass (Astron. J. 69 (1964) 73), (k,)."""
    x, y = q[:, 0], q[:, 1]
    return 0.5 * np.sum(p**2 + q**2, axis=-1) + x**2 * y - y**3 / 3.0


def double_pendulum(problem: Problem, q: Array, p: Array) -> Array:
    """The energy of two point masses on massless rods, with absolute angles."""
    (m1, m2), (l1, l2) = problem.parameters["masses"], problem.parameters["lengths"]
    g, both = problem.parameters["gravity"], m1 + m2
    first, second, mixed = both * l1**2, m2 * l2**2, m2 * l1 * l2 * np.cos(q[:, 0] - q[:, 1])
    squares = second * p[:, 0] ** 2 + first * p[:, 1] ** 2 - 2.0 * mixed * p[:, 0] * p[:, 1]
    kinetic = 0.5 * squares / (first * second - mixed**2)
    return kinetic - g * (both * l1 * np.cos(q[:, 0]) + m2 * l2 * np.cos(q[:, 1]))


def relative_energy_error(problem: Problem, q: Any, v: Any) -> Array:
    """(E(q, v) - E(q0, v0)) / |E(q0, v0)| of point masses, to about 1e-29.

    Parameters
    ----------
    q, v
        DoubleDouble of shape (..., bodies, dimension): a state with its low parts
    """
    start = _energy(problem, exactly(problem.q0), exactly(problem.v0))
    change = (_energy(problem, q, v) - start) / start
    return -np.asarray(change.hi) if start.hi < 0.0 else np.asarray(change.hi)


def exactly(x: Array) -> DoubleDouble:
    """The same numbers as DoubleDouble, with zero low parts."""
    return DoubleDouble(x, np.zeros_like(x))


def _energy(problem: Problem, q: DoubleDouble, v: DoubleDouble) -> DoubleDouble:
    """sum m v.v / 2 - sum over pairs G m_i m_j / r_ij, shape (...)."""
    system: Any = problem.system
    i, j = np.triu_indices(system.masses.size, 1)
    kinetic = _total(_total(v * v) * exactly(0.5 * system.masses))
    gap = q[..., i, :] - q[..., j, :]
    weight = exactly(system.masses[i]) * exactly(system.masses[j])
    return kinetic - _total(weight / _root(_total(gap * gap))) * system.G


def _total(x: DoubleDouble) -> DoubleDouble:
    """The sum over the last axis."""
    total = x[..., 0]
    for k in range(1, x.hi.shape[-1]):
        total = total + x[..., k]
    return total


def _root(x: DoubleDouble) -> DoubleDouble:
    """The square root: one Newton step from that of the high part."""
    guess = np.sqrt(x.hi)
    return (x - DoubleDouble(guess) * guess) / (2.0 * guess) + guess
