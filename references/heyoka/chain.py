"""heyoka on a chain of links: Taylor's method, its mass matrix eliminated in symbols."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import PlanarChain, Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import require
from references.heyoka import engine as heyoka_engine
from references.heyoka.elimination import solved
from references.heyoka.engine import DEFAULT
from references.setting import check_keys, described, sample_times
from references.textbook.chain_equations import ChainEquations, is_chain


@dataclass(frozen=True)
class HeyokaChain:
    """A PlanarChain, in double or quadruple precision.

    precision  "double", or "real128": numbers, times and states are quadruple throughout

    Setting as `references.heyoka.taylor.HeyokaTaylor`.
    """

    name: str = "heyoka, chains"
    precision: str = "double"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why heyoka cannot be used here; empty when it can."""
        return heyoka_engine.missing(self.precision)

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian that is a PlanarChain."""
        return is_chain(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples", *DEFAULT))
        times = sample_times(problem.t0, duration, setting)
        options = heyoka_engine.options(setting, self.precision)
        number = heyoka_engine.kind(self.precision)
        system: Any = problem.system
        engine = _compiled(system.function, self.precision, *heyoka_engine.switches(options))
        start = np.concatenate([problem.q0, problem.v0]).astype(number)
        states, steps, failure = heyoka_engine.propagated(
            engine, start, times - problem.t0, problem.t0, "the state is not finite."
        )
        q, v = np.split(states.astype(np.float64), 2, axis=1)
        return as_trajectory(
            problem,
            described(self.name, {**setting, **options}, heyoka_engine.engine_name(self.precision)),
            times,
            q,
            v,
            counts={"steps": steps},
            failure=failure,
        )


@lru_cache(maxsize=16)
def _compiled(
    chain: PlanarChain, precision: str, tolerance: float, accurate: bool, compact: bool
) -> Any:
    """heyoka's integrator of this chain, for any start."""
    import heyoka

    number = heyoka_engine.kind(precision)
    equations = ChainEquations.of(chain, number)
    S, m = equations.levers, equations.masses
    n = len(m)
    q, v = (heyoka.make_vars(*(f"{name}{i}" for i in range(n))) for name in "qv")
    q, v = (x if n > 1 else [x] for x in (q, v))
    both = [[sum(m[k] * S[k, i] * S[k, j] for k in range(n)) for j in range(n)] for i in range(n)]
    weight = [equations.gravity * sum(m[k] * S[k, i] for k in range(n)) for i in range(n)]
    M = [[heyoka.expression(both[i][j]) * heyoka.cos(q[i] - q[j]) for j in range(n)]
         for i in range(n)]  # fmt: skip
    pull = []
    for i in range(n):
        M[i][i] = heyoka.expression(both[i][i] + equations.moments[i])
        across = [
            heyoka.expression(both[i][j]) * heyoka.sin(q[i] - q[j]) * v[j] * v[j]
            for j in range(n)
            if j != i
        ]
        pull.append(-sum(across, heyoka.expression(weight[i]) * heyoka.sin(q[i])))
    state = [*q, *v]
    return heyoka.taylor_adaptive(
        list(zip(state, [*v, *solved(M, pull)], strict=True)),
        np.zeros(2 * n).astype(number),
        time=number(0.0),
        tol=number(tolerance),
        high_accuracy=accurate,
        compact_mode=compact,
        fp_type=number,
    )


HEYOKA_CHAIN = HeyokaChain()
HEYOKA_CHAIN_QUADRUPLE = HeyokaChain(
    "heyoka, chains, quadruple precision", precision="real128", exact=True
)
