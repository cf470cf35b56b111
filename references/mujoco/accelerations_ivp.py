"""SciPy's DOP853 on the accelerations that MuJoCo computes of a tree.

The tolerance sets the accuracy, down to some 1e-13; MuJoCo's integrators are not used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.contender import require
from references.mujoco import engine as mujoco_engine
from references.mujoco.body import is_tree
from references.tree_ivp import integrated


@dataclass(frozen=True, eq=False)
class MujocoAccelerations:
    """Setting and steps as in `references.tree_ivp.integrated`."""

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "mujoco-core"

    name: str = "SciPy DOP853 on MuJoCo's accelerations"
    order: int = 8
    exact: bool = False
    build: mujoco_engine.Builder = mujoco_engine.at_start

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        return mujoco_engine.missing()

    def supports(self, problem: Problem) -> bool:
        """Trees, their damping included."""
        return is_tree(problem) or mujoco_engine.is_of_user(self.build, problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        import mujoco

        require(self, problem)
        _, model, mj_data = self.build(problem)
        # The integrator "discrete" would add its damping to qacc.
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4

        def accelerations(qpos: Array, qvel: Array) -> Array:
            mj_data.qpos[:], mj_data.qvel[:] = qpos, qvel
            mujoco.mj_forward(model, mj_data)
            return mj_data.qacc

        with mujoco_engine.silence():
            return integrated(
                self.name, mujoco_engine.version(), accelerations, problem, duration, setting
            )


MUJOCO_ACCELERATIONS = MujocoAccelerations()
