"""SciPy's DOP853 on a chain of links, by its mass matrix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.contender import require
from references.forces.force import checked
from references.scipy.ivp import run_on_coordinates
from references.textbook.chain_equations import ChainEquations, is_chain


@dataclass(frozen=True)
class ChainIvp:
    """One method of solve_ivp on (q, v)' = (v, q'') of `references.textbook.chain_equations`.

    Setting and states between steps as `references.scipy.ivp.ScipyIvp`.
    """

    name: str = "SciPy DOP853, chains"
    solver: str = "DOP853"
    order: int = 8
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian that is a PlanarChain, with any external force."""
        return is_chain(problem, forced=True)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        system: Any = problem.system
        equations, n = ChainEquations.of(system.function), problem.q0.size

        def accelerated(q: Array, v: Array, t: float) -> Array:
            if system.force is None:
                return equations.acceleration(q, v)
            given = (q.copy(), v.copy(), t) if system.timed_force else (q.copy(), v.copy())
            return equations.acceleration(q, v, checked(system.force(*given), (n,)))

        return run_on_coordinates(self, problem, duration, setting, accelerated)


CHAIN_DOP853 = ChainIvp()
