"""MuJoCo's own ensembles: `mujoco.rollout` in threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from galvi import Problem
from galvi.arrays import Array
from references.mujoco import engine
from references.mujoco.body import from_mujoco, supports, to_mujoco


@dataclass(frozen=True)
class MujocoRollout:
    """Many starts of one body in MuJoCo's RK4, its most accurate integrator."""

    name: str = "MuJoCo rollout, RK4"

    @property
    def missing(self) -> str:
        """Why MuJoCo cannot be used here; empty when it can."""
        return engine.missing()

    def supports(self, problem: Problem) -> bool:
        """As MuJoCo's other references."""
        return supports(problem)

    def prepared(
        self, problem: Problem, q0: Array, v0: Array, step: float, steps: int, threads: int
    ) -> Callable[[], Array]:
        """A function that runs all members (n, ...) and returns their last configurations."""
        import mujoco
        from mujoco.rollout import Rollout

        joint, model, _ = engine.compiled(problem.system)
        model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
        mj_data = [mujoco.MjData(model) for _ in range(threads)]
        qpos, qvel = to_mujoco(joint, q0, v0)
        starts = np.concatenate([np.zeros((len(qpos), 1)), qpos, qvel], axis=1)
        states = np.empty((len(qpos), steps, starts.shape[1]))
        pool = Rollout(nthread=threads)

        def call() -> Array:
            pool.rollout(model, mj_data, starts, nstep=steps, state=states, skip_checks=False)
            last = states[:, -1, 1:]
            return from_mujoco(joint, last[:, : qpos.shape[1]], last[:, qpos.shape[1] :])[0]

        return call


MUJOCO_ROLLOUT = MujocoRollout()
