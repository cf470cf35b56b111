"""Many members in heyoka: batches in vector instructions, shared by threads.

Its own ensembles copy the integrator, with its compiled code, for each batch; a loop over batches
in each thread copies it once.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Canonical, CentralForce, Problem
from galvi.arrays import Array
from references.heyoka import engine
from references.newton import is_forced, replaces_force


@dataclass(frozen=True)
class HeyokaBatches:
    """Many starts about a fixed centre, in ``taylor_adaptive_batch``.

    own  by heyoka's ``ensemble_propagate_until_batch``, else by a loop in each thread
    """

    name: str
    own: bool

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return engine.missing("double")

    def supports(self, problem: Problem) -> bool:
        """A scalar mass about a fixed centre."""
        system = problem.system
        central = isinstance(system, Canonical) and isinstance(system.potential, CentralForce)
        return central and not is_forced(problem) and not replaces_force(problem)

    def prepared(
        self, problem: Problem, q0: Array, v0: Array, duration: float, tolerance: float,
        threads: int,
    ) -> Callable[[], Array]:  # fmt: skip
        """A call that runs all members (n, d), n a multiple of the batch, and returns their last
        places; the integrator is compiled here."""
        import heyoka

        system: Any = problem.system
        d, batch = q0.shape[1], heyoka.recommended_simd_size()
        x, v = (heyoka.make_vars(*(f"{letter}{i}" for i in range(d))) for letter in ("x", "v"))
        square = heyoka.sum([place * place for place in x])
        pull = -(system.potential.mu / float(system.mass)) * square**-1.5
        equations = [(x[i], v[i]) for i in range(d)] + [(v[i], pull * x[i]) for i in range(d)]
        starts = np.concatenate([q0, v0], axis=1).reshape(-1, batch, 2 * d).transpose(0, 2, 1)
        one = heyoka.taylor_adaptive_batch(
            equations, np.ascontiguousarray(starts[0]), tol=tolerance, compact_mode=False
        )

        def start(integrator: Any, k: int) -> Any:
            integrator.set_time(0.0)
            integrator.state[:] = starts[k]
            return integrator

        copies = [copy.deepcopy(one) for _ in range(threads)]

        def some(thread: int) -> list[Array]:
            found = []
            for k in range(thread, len(starts), threads):
                start(copies[thread], k).propagate_until(duration)
                found.append(copies[thread].state.copy())
            return found

        def call() -> Array:
            states = np.empty(starts.shape)
            if self.own:
                found = heyoka.ensemble_propagate_until_batch(one, duration, len(starts), start)
                states[:] = [integrator[0].state for integrator in found]
            else:
                with ThreadPoolExecutor(threads) as pool:
                    for thread, rows in enumerate(pool.map(some, range(threads))):
                        states[thread::threads] = rows
            return states.transpose(0, 2, 1).reshape(-1, 2 * d)[:, :d]

        return call


HEYOKA_BATCHES = HeyokaBatches("heyoka, batches in threads", own=False)
HEYOKA_ENSEMBLE = HeyokaBatches("heyoka, its ensembles of batches", own=True)
