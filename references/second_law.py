"""Newton's second law of a problem: M v' = -dV/dq + f, f of whatever the problem's force takes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array


def is_forced(problem: Problem) -> bool:
    """Whether a force acts that no potential has: what does not know it must not take the problem.

    By the system's field ``force``; systems without that field have none.
    """
    return getattr(problem.system, "force", None) is not None


def external_force(system: Any, q: Array, v: Array, t: float) -> Array:
    """f at one configuration, velocity and time, in v's shape; on a group in the body's frame."""
    given = (q.copy(), v.copy(), t) if system.timed_force else (q.copy(), v.copy())
    force: Array = np.asarray(system.force(*given), dtype=np.float64)
    return force


def acceleration(problem: Problem) -> Callable[[Array, Array, float], Array]:
    """a(q, v, t) on a vector space, in the shape of q."""
    system: Any = problem.system
    if not is_forced(problem):

        def free(q: Array, v: Array, t: float) -> Array:
            a: Array = system.acceleration(q, t)
            return a

        return free

    def forced(q: Array, v: Array, t: float) -> Array:
        pushed = external_force(system, q, v, t) - system.potential_gradient(q, t)
        a: Array = system.velocity(pushed)
        return a

    return forced
