"""heyoka on a chain of links: Taylor's method, its mass matrix eliminated in symbols."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from galvi import PlanarChain, Problem
from references.heyoka import engine as heyoka_engine
from references.heyoka.elimination import solved
from references.heyoka.on_coordinates import OnCoordinates, compiled
from references.textbook.chain_equations import ChainEquations, is_chain


@dataclass(frozen=True)
class HeyokaChain(OnCoordinates):
    """A PlanarChain."""

    name: str = "heyoka, chains"

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian that is a PlanarChain."""
        return is_chain(problem)

    def integrator(self, problem: Problem, tolerance: float, accurate: bool, compact: bool) -> Any:
        """As `OnCoordinates.integrator`."""
        system: Any = problem.system
        return _compiled(system.function, self.precision, tolerance, accurate, compact)


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
    return compiled(q, v, solved(M, pull), precision, tolerance, accurate, compact)


HEYOKA_CHAIN = HeyokaChain()
HEYOKA_CHAIN_QUADRUPLE = HeyokaChain(
    "heyoka, chains, quadruple precision", precision="real128", exact=True
)
