"""Momenta and velocities of any system's states."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.system import System


def momentum_at(system: System, q: Array, v: Array, t: Any) -> Array:
    """dL/dv at configurations q, velocities v (..., d) and times t (...)."""
    return system.momentum(v, q, t) if isinstance(system, Lagrangian) else system.momentum(v)


def velocity_at(system: System, q: Array, p: Array, t: Any, near: Array | None = None) -> Array:
    """The velocities that have the momenta p (..., d) at q and t (...).

    near  (d,) a velocity close to the first one
    """
    return system.velocity(p, q, t, near) if isinstance(system, Lagrangian) else system.velocity(p)


def kinetic_energy(system: System, p: Array) -> Array:
    """p . v / 2 at momenta p (n, ...) of a system whose v is linear in p, (n,).

    That of a massless body, whose p is 0, is 0.
    """
    twice = np.where(p == 0.0, 0.0, p * system.velocity(p))
    return 0.5 * twice.sum(axis=tuple(range(1, p.ndim)))
