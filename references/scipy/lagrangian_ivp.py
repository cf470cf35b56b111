"""Chains of rods and Lagrangians in coordinates, by SciPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import Lagrangian, Problem, Trajectory
from galvi.arrays import Array
from references.contender import require
from references.forces.force import checked
from references.scipy.ivp import run_on_coordinates
from references.textbook.chain_equations import ChainEquations, is_chain
from references.textbook.lagrange_equations import LagrangeEquations, time_symbol


@dataclass(frozen=True)
class ChainIvp:
    """One method of solve_ivp on (q, v)' = (v, q'') of `references.textbook.chain_equations`.

    Setting and states between steps as `references.scipy.ivp.ScipyIvp`.
    """

    fixed_step: ClassVar[bool] = False

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
            arguments = (q.copy(), v.copy(), t) if system.timed_force else (q.copy(), v.copy())
            return equations.acceleration(q, v, checked(system.force(*arguments), (n,)))

        return run_on_coordinates(self, problem, duration, setting, accelerated)


CHAIN_DOP853 = ChainIvp()


@dataclass(frozen=True)
class LagrangianIvp:
    """One method of solve_ivp on (q, v)' = (v, a), a from `LagrangeEquations`.

    Setting and states between steps as `references.scipy.ivp.ScipyIvp`.
    """

    fixed_step: ClassVar[bool] = False

    name: str = "SciPy DOP853, Lagrangians"
    solver: str = "DOP853"
    order: int = 8
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Lagrangian from SymPy, without external force."""
        is_lagrangian = isinstance(problem.system, Lagrangian)
        return is_lagrangian and LagrangeEquations.of(problem) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        equations = LagrangeEquations.of(problem)
        assert equations is not None
        return run_on_coordinates(self, problem, duration, setting, accelerations(equations))


@lru_cache(maxsize=16)
def accelerations(equations: LagrangeEquations) -> Callable[[Array, Array, float], Array]:
    """a(q, v, t) (d,) in double precision."""
    import sympy

    states = [equations.q, equations.v, time_symbol()]
    pull = sympy.lambdify(states, list(equations.pull), cse=True)
    mass = sympy.lambdify(states, [list(row) for row in equations.mass], cse=True)

    def accelerated(q: Array, v: Array, t: float) -> Array:
        force = np.array(pull(q, v, t), dtype=np.float64)
        if not equations.mass:
            return force
        return np.linalg.solve(np.array(mass(q, v, t), dtype=np.float64), force)

    return accelerated


LAGRANGIAN_DOP853 = LagrangianIvp()
