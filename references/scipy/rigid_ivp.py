"""SciPy's solve_ivp on a rigid body: DOP853 on quaternions, RK45 (ode45) on rotation matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import scipy

from galvi import Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import times_of_run
from references.rigid_equations import RigidEquations, is_rigid_body
from references.scipy.ivp import SETTINGS, accuracy_note, solve, with_tolerances
from references.setting import described


@dataclass(frozen=True)
class RigidIvp:
    """One method of solve_ivp on (attitude, body momentum), any potential, any external torque.

    Attributes
    ----------
    quaternions
        the attitude is a quaternion, normalised wherever it becomes a matrix; otherwise the nine
        entries of the matrix, which need not stay a rotation

    Notes
    -----
    Setting and states between steps as `references.scipy.ivp.ScipyIvp`.
    """

    fixed_step: ClassVar[bool] = False

    name: str
    solver: str
    order: int
    quaternions: bool
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Every RigidBody."""
        return is_rigid_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        times = times_of_run(self, problem, duration, setting, *SETTINGS)
        equations = RigidEquations(problem, self.quaternions)
        states, calls, failure = solve(
            self.solver, equations.slope(), times, equations.start, setting
        )
        return as_trajectory(
            problem,
            described(self.name, with_tolerances(setting), f"scipy {scipy.__version__}"),
            times,
            equations.attitudes(states),
            p=states[:, -3:],
            counts={"force_evaluations": calls},
            failure=failure,
            notes=[accuracy_note(setting)],
        )


RIGID_DOP853 = RigidIvp("SciPy DOP853, quaternions", "DOP853", order=8, quaternions=True)
RIGID_ODE45 = RigidIvp("SciPy RK45 (ode45), matrices", "RK45", order=5, quaternions=False)
