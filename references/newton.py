"""Newton's second law of a problem: M v' = -dV/dq + f, f of whatever the problem's force takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from galvi import Canonical, Problem
from galvi.arrays import Array
from galvi.systems.forces.external_force import force_at


def is_forced(problem: Problem) -> bool:
    """Whether a force acts that no potential has: what does not know it must not take the problem.

    By the system's field ``force``; systems without that field have none.
    """
    return getattr(problem.system, "force", None) is not None


def is_moved_by(problem: Problem, potential: type) -> bool:
    """Whether such a potential alone moves a scalar or diagonal mass."""
    system = problem.system
    return (
        isinstance(system, Canonical)
        and isinstance(system.potential, potential)
        and system.gradient is None
        and system.mass.ndim < 2
        and not is_forced(problem)
    )


def acceleration(problem: Problem) -> Callable[[Array, Array, float], Array]:
    """a(q, v, t) on a vector space, in the shape of q."""
    system: Any = problem.system
    if not is_forced(problem):

        def free(q: Array, v: Array, t: float) -> Array:
            a: Array = system.acceleration(q, t)
            return a

        return free

    def forced(q: Array, v: Array, t: float) -> Array:
        pushed = force_at(system, q, v, t) - system.potential_gradient(q, t)
        a: Array = system.velocity(pushed)
        return a

    return forced
