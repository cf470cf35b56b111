"""Compares the energy at the end of a run with that at its start."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.potentials.potential import Potential
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody

USABLE = 0.1  # largest change of the energy, over |T| + |V|, of a usable run


def conserves_energy(system: Any) -> bool:
    """Whether a system conserves its energy and evaluates it to round-off at little cost."""
    if isinstance(system, NBody | FreeBody):
        return True
    if getattr(system, "force", None) is not None:
        return False
    if isinstance(system, Lagrangian):
        return not system.explicit_time and system.potential_calls_per_force == 0
    if isinstance(system, RigidBody):
        return system.gradient is None and isinstance(system.potential, UniformGravity | None)
    return isinstance(system, Canonical) and isinstance(system.potential, Potential)


def energy_change(problem: Problem, q: Array, v: Array, p: Array | None = None) -> float:
    """Change of the energy from the start to (q, v), over |T| + |V| at the start.

    p  for a Lagrangian, the momentum at (q, v); None: computed from v
    """
    with np.errstate(all="ignore"):
        start, end = _energy(problem, problem.q0, problem.v0), _energy(problem, q, v, p)
        size, change = abs(start[0]) + abs(start[1]), abs(sum(end) - sum(start))
    return change / size if size > 0.0 else (0.0 if change == 0.0 else np.inf)


def _energy(problem: Problem, q: Array, v: Array, p: Array | None = None) -> tuple[float, float]:
    """T and V; for a Lagrangian p . v and -L, with p computed from v unless given."""
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        p = system.momentum(v, q, problem.t0) if p is None else p
        return float(p @ v), -system.value(q, v, problem.t0)
    q, v = q.reshape(problem.q0.shape), v.reshape(problem.v0.shape)
    kinetic = 0.5 * float(np.sum(v * system.momentum(v)))
    return kinetic, float(system.potential_energy(q, np.zeros(())))
