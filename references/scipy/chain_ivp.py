"""SciPy's DOP853 on a chain of links, by its mass matrix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.contender import require
from references.forces.force import checked
from references.scipy.ivp import SETTINGS, accuracy_note, solve, with_tolerances
from references.setting import check_keys, described, sample_times
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
        check_keys(setting, SETTINGS)
        times = sample_times(problem.t0, duration, setting)
        system: Any = problem.system
        equations, n = ChainEquations.of(system.function), problem.q0.size

        def force(t: float, q: Array, v: Array) -> Array:
            if system.force is None:
                return np.zeros(n)
            given = (q.copy(), v.copy(), t) if system.timed_force else (q.copy(), v.copy())
            return checked(system.force(*given), (n,))

        def slope(t: float, y: Array) -> Array:
            q, v = y[:n], y[n:]
            return np.concatenate([v, equations.acceleration(q, v, force(t, q, v))])

        start = np.concatenate([problem.q0, problem.v0])
        states, calls, failure = solve(self.solver, slope, times, start, setting)
        return as_trajectory(
            problem,
            described(self.name, with_tolerances(setting), f"scipy {scipy.__version__}"),
            times,
            states[:, :n],
            states[:, n:],
            counts={"force_evaluations": calls},
            failure=failure,
            note=accuracy_note(setting),
        )


CHAIN_DOP853 = ChainIvp()
