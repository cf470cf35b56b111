"""Any system as a Lagrangian, for motion in a clock in transformed time."""

from __future__ import annotations

from functools import singledispatch
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Rn
from galvi.kernels.forces.celestial import (
    FIRST_NUMBER,
    SOURCE,
    TARGET,
    WEIGHT,
    pole_pull,
    power_pull,
)
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody


@singledispatch
def lagrangian_of(system: Any, problem: Problem) -> Lagrangian:
    """The Lagrangian of a system, of flat configurations or matrices, without checks."""
    return cast(Lagrangian, system.lagrangian)


@lagrangian_of.register
def _(system: Lagrangian, problem: Problem) -> Lagrangian:
    return system


@lagrangian_of.register
def _(system: Canonical, problem: Problem) -> Lagrangian:
    def L(q: Any, v: Any, *t: Any) -> Any:
        return 0.5 * (v @ system.momentum(v)) - system.potential(q, *t)

    def slopes(q: Any, v: Any, *t: Any) -> Array:
        return np.concatenate([system.momentum(v), -system.potential_gradient(q, *(t or (0.0,)))])

    return Lagrangian(
        L,
        Rn(problem.q0.size),
        slopes,
        system.force,
        explicit_time=system.explicit_time,
        timed_force=system.timed_force,
        check=False,
    )


@lagrangian_of.register
def _(system: NBody, problem: Problem) -> Lagrangian:
    size, acting = problem.q0.shape[1], system.acting
    masses = np.repeat(system.masses, size)
    n = system.masses.size
    pairs = [
        (i, j, float(system.G * system.masses[i] * system.masses[j]))
        for i in range(n)
        for j in range(i + 1, n)
    ]

    def L(q: Any, v: Any) -> Any:
        total: Any = 0.5 * (v @ (masses * v))
        for i, j, mass in pairs:
            gaps = [q[i * size + k] - q[j * size + k] for k in range(size)]
            total = total + mass / np.sqrt(sum((gap * gap for gap in gaps), 0.0))
        for k, row in enumerate(acting.terms):
            first, second = (int(row[column]) * size for column in (SOURCE, TARGET))
            way: Any = [q[second + x] - q[first + x] for x in range(size)]
            law: Any = pole_pull if k < acting.poles else power_pull
            total = total - row[WEIGHT] * law([*way, 0.0][:3], row[FIRST_NUMBER:].tolist())[3]
        return total

    def slopes(q: Any, v: Any) -> Array:
        pull = system.fall(q.reshape(-1, size)).ravel()
        return np.concatenate([masses * v, masses * pull])

    def force(q: Any, v: Any, t: float) -> Array:
        return (
            masses * acting.extra_accelerations(q.reshape(-1, size), v.reshape(-1, size), t).ravel()
        )

    return Lagrangian(
        L,
        Rn(problem.q0.size),
        slopes,
        None if acting.conserve else force,
        timed_force=not acting.conserve,
        check=False,
    )
