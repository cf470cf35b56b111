"""Euler's methods and Stormer-Verlet's, on vector spaces and on matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, Trajectory
from references.as_trajectory import as_trajectory, non_finite
from references.contender import steps_of_run
from references.rigid_equations import RigidEquations, is_rigid_body
from references.setting import described
from references.textbook.nystrom import Nystrom, splitting

EXPLICIT_EULER = Nystrom(
    "explicit Euler", order=1, stages=((0.0,),), nodes=(0.0,), position=(0.0,), velocity=(1.0,)
)
SYMPLECTIC_EULER = splitting("symplectic Euler", order=1, nodes=(0.0,), kicks=(1.0,))
SEMI_IMPLICIT_EULER = replace(SYMPLECTIC_EULER, name="semi-implicit Euler")
STORMER_VERLET = splitting("Stormer-Verlet", order=2, nodes=(0.0, 1.0), kicks=(0.5, 0.5))


@dataclass(frozen=True)
class MatrixEuler:
    """R' = R + h R hat(w), p' = p + h (p x w + torque); setting: step, save_every.

    R does not stay a rotation, nor |p| constant, which this method is here to show.
    """

    fixed_step: ClassVar[bool] = True

    name: str = "explicit Euler, matrices"
    order: int = 1
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Every RigidBody."""
        return is_rigid_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`."""
        steps = steps_of_run(self, problem, duration, setting)
        times = steps.times(problem.t0)
        equations = RigidEquations(problem, quaternions=False)
        slope, state = equations.slope(), equations.start
        saved = np.full((len(times), state.size), np.nan)
        saved[0], row, failure = state, 1, None
        for k in range(1, steps.count + 1):
            with np.errstate(all="ignore"):  # non-finite states are checked below
                state = state + steps.step * slope(problem.t0 + (k - 1) * steps.step, state)
            if not np.all(np.isfinite(state)):
                failure = non_finite(k, steps.saved, times)
                break
            if k == steps.saved[row]:
                saved[row] = state
                row += 1
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            equations.attitudes(saved),
            p=saved[:, -3:],
            counts={"steps": k - (failure is not None), "force_evaluations": k},
            step=steps.step,
            failure=failure,
        )


MATRIX_EULER = MatrixEuler()
