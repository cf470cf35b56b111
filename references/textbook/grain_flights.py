"""DOP853 with contacts, compiled, for many grains in the rotor's wind."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy.integrate

from galvi import Problem
from galvi.arrays import Array
from references.newton import external_force
from references.textbook.grain_kernel import CONTACTS, compiled

TIGHT = 1e-13  # relative to 1 m and 1 m/s as well


class Landings(NamedTuple):
    """The ends of n flights: states and times (n,), and whether a grain stays on the ground."""

    q: Array
    v: Array
    t: Array
    landed: Any


def landings(
    problem: Problem, q0: Array, v0: Array, t0: Array, until: float, *,
    restitution: float | None = None, slowest: float = 0.05, tolerance: float = TIGHT,
) -> Landings:  # fmt: skip
    """The flights of n grains of a `galvi.problems.brownout` from (q0, v0) (n, 3) at t0 (n,).

    restitution, slowest  as benchmarks.applications.brownout.flights.Ground

    The moment of a contact is the root of the end of a step, found by Newton's method. Raises
    RuntimeError where the steps became too small or contacts did not end.
    """
    system: Any = problem.system
    drag, mass = external_force(problem), float(system.mass)
    starts = np.ascontiguousarray(np.column_stack([q0, v0, t0]))
    ends = np.zeros((len(starts), 8))
    e = -1.0 if restitution is None else float(restitution)
    gravity = -float(system.potential.force[2]) / mass
    _kernel()(drag.function, drag.numbers, 1.0 / mass, gravity, starts, until, tolerance, e,
              slowest, _tableau(), ends)  # fmt: skip
    if np.any(ends[:, 7] < 0.0):
        raise RuntimeError(
            f"{int(np.sum(ends[:, 7] < 0.0))} grains have no end by DOP853: the steps became too "
            f"small, or the contacts {CONTACTS}. Loosen the tolerance, or give a larger slowest."
        )
    return Landings(ends[:, :3], ends[:, 3:6], ends[:, 6], ends[:, 7] > 0.0)


@cache
def _kernel() -> Any:
    return compiled()


@cache
def _tableau() -> tuple[Array, Array, Array]:
    """A with the weights as its last row (13, 12), and the two error estimates (12,)."""
    method: Any = scipy.integrate.DOP853
    A = np.vstack([method.A, method.B])
    return (
        np.ascontiguousarray(A), np.ascontiguousarray(method.E3[:-1]),
        np.ascontiguousarray(method.E5[:-1]),
    )  # fmt: skip
