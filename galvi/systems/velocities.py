"""Momenta and velocities of any system's states."""

from __future__ import annotations

from typing import Any

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
