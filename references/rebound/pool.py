"""Many planetary systems in REBOUND: one simulation after another in each of several processes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.rebound import saba, whfast
from references.rebound.simulation import arithmetic_kept, missing, simulation, supports


@dataclass(frozen=True)
class ReboundPool:
    """Many starts of one system with a fixed-step integrator of REBOUND.

    integrator, options  as in REBOUND
    """

    name: str
    integrator: str
    options: tuple[tuple[str, Any], ...] = ()

    @property
    def missing(self) -> str:
        """Why REBOUND cannot be used here; empty when it can."""
        return missing()

    def supports(self, problem: Problem) -> bool:
        """As REBOUND's other references."""
        return supports(problem)

    def prepared(
        self, problem: Problem, q0: Array, v0: Array, step: float, steps: int, pool: Any, parts: int
    ) -> Callable[[], Array]:
        """A call that runs all members (n, ...) and returns their last configurations.

        pool   of processes that wait, with ``map``
        parts  how many pieces of work are sent to it
        """
        one = partial(last_places, problem.system, self.integrator, dict(self.options), step, steps)
        pieces = [np.array_split(array, parts) for array in (q0, v0)]
        return lambda: np.concatenate(list(pool.map(one, *pieces)))


def last_places(
    system: Any, integrator: str, options: Mapping[str, Any], step: float, steps: int, q: Array,
    v: Array,
) -> Array:  # fmt: skip
    """The last places of members that start at q and v, (n, bodies, dimension) each."""
    problem, found = Problem(system, q[0], v[0]), np.empty(q.shape)
    with arithmetic_kept():
        for k in range(len(q)):
            made = simulation(replace(problem, q0=q[k], v0=v[k]), integrator, options)
            made.engine.dt = step
            made.engine.exact_finish_time = 0
            made.engine.steps(steps)
            made.engine.synchronize()
            found[k] = made.states()[0]
    return found


REBOUND_POOLS = (
    ReboundPool("REBOUND WHFast, processes", "whfast", tuple(whfast.BEST.items())),
    ReboundPool("REBOUND SABA, processes", "saba", tuple(saba.BEST.items())),
)
