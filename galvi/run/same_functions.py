"""Whether the functions of a problem still are those of a run, whose steps are done again."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem
from galvi.run.energies import asks_functions
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.traces import Traces, traces


class SameFunctions:
    """Raises ValueError, when called, once the problem's functions do not return at its start what
    they did when this was made.

    traced  whether the run is that of what tracing them found, which is kept with the system
    """

    def __init__(self, problem: Problem, traced: bool) -> None:
        self.problem, self.values = problem, _values(problem)
        self.found: Traces | None = traces(problem.system) if traced else None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "found": None}

    def __call__(self) -> None:
        if self.values is None:
            return
        if self.found is not None and traces(self.problem.system) is self.found:
            return
        now = _values(self.problem)
        if now is None or not np.array_equal(self.values, now, equal_nan=True):
            raise ValueError(
                "this run keeps no curves, so that its steps are done again, and the functions of "
                "its system do not return what they did: a number to which they refer has "
                "changed. Change it back, or keep the curves of a run with curves=True."
            )


def _values(problem: Problem) -> Array | None:
    """What the functions return at the start, (n,); None where there are none or they raise."""
    system: Any = problem.system
    q, v, t = problem.q0, problem.v0, problem.t0
    found: list[Any] = []
    with np.errstate(all="ignore"):
        try:
            if isinstance(system, NBody):
                found += [system.acceleration(q, t, v)] if system.forces else []
            elif isinstance(system, Lagrangian):
                found += [] if system.brings_slopes else [system.value(q, v, t)]
                found += [system.slopes(*system._arguments(q, v, t))] if system.slopes else []
            elif asks_functions(system) or getattr(system, "gradient", None) is not None:
                given = getattr(system, "gradient", None) is not None
                slope, energy = system.potential_gradient, system.potential_energy
                found += [slope(q, t) if given else energy(q[None], np.array([t]))]
            if callable(getattr(system, "force", None)):
                found += [force_at(system, q, v, t)]
        except Exception:  # a user's function may raise anything
            return None
    return np.concatenate([np.ravel(x) for x in found]) if found else None
