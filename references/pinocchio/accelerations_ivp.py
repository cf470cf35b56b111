"""SciPy's DOP853 on the accelerations that Pinocchio computes of a tree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from galvi import Multibody, Problem, Trajectory
from references.contender import require
from references.pinocchio import tree
from references.tree_ivp import integrated


@dataclass(frozen=True, eq=False)
class PinocchioAccelerations:
    """Setting and steps as of `references.tree_ivp.integrated`."""

    name: str = "SciPy DOP853 on Pinocchio's accelerations"
    order: int = 8
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        return tree.missing()

    def supports(self, problem: Problem) -> bool:
        """Trees, their springs and damping included."""
        return isinstance(problem.system, Multibody)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        compiled = tree.compiled(problem.system)
        return integrated(
            self.name, tree.version(), compiled.accelerations, problem, duration, setting
        )


PINOCCHIO_ACCELERATIONS = PinocchioAccelerations()
