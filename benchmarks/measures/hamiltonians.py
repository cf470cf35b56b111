"""Energies as functions of q and p, (k, ...) each, by textbook formulas; results (k,).

Conservation by a contender is judged with these, independently of galvi's own functions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.measures import independent_invariants
from galvi import Problem
from galvi.arrays import Array


def energy(problem: Problem, q: Array, p: Array) -> Array:
    """The energy of `benchmarks.measures.independent_invariants`, (k,). TypeError for a system
    without a formula there."""
    system: Any = problem.system
    return independent_invariants.energy(problem, q, system.velocity(p))


def henon_heiles(problem: Problem, q: Array, p: Array) -> Array:
    """For unit mass: p^2 / 2 + (x^2 + y^2) / 2 + x^2 y - y^3 / 3 (Astron. J. 69 (1964) 73)."""
    x, y = q[:, 0], q[:, 1]
    found: Array = 0.5 * np.sum(p**2 + q**2, axis=-1) + x**2 * y - y**3 / 3.0
    return found


def double_pendulum(problem: Problem, q: Array, p: Array) -> Array:
    """The energy of two point masses on massless rods, with absolute angles."""
    (m1, m2), (l1, l2) = problem.parameters["masses"], problem.parameters["lengths"]
    g, both = problem.parameters["gravity"], m1 + m2
    first, second, mixed = both * l1**2, m2 * l2**2, m2 * l1 * l2 * np.cos(q[:, 0] - q[:, 1])
    squares = second * p[:, 0] ** 2 + first * p[:, 1] ** 2 - 2.0 * mixed * p[:, 0] * p[:, 1]
    kinetic = 0.5 * squares / (first * second - mixed**2)
    found: Array = kinetic - g * (both * l1 * np.cos(q[:, 0]) + m2 * l2 * np.cos(q[:, 1]))
    return found
