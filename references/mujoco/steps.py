"""MuJoCo's integrators, as values of one class.

MuJoCo is a multibody engine with contacts: on one body or chain much of its time is the price of
generality. Its documentation advises RK4 where energy should be conserved for long. The others are
of first order; `implicit` damps a tumbling body by design.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import Problem, Trajectory
from references.as_trajectory import Failure, as_trajectory
from references.contender import steps_of_run
from references.engine_clock import engine_time
from references.mujoco import engine as mujoco_engine
from references.mujoco.body import from_mujoco, supports
from references.setting import described

CHUNK = 100_000  # number of steps between two checks for Ctrl-C
DEFAULT_STEP = 0.002  # seconds, MuJoCo's default


@dataclass(frozen=True, eq=False)
class MujocoSteps:
    """Equal steps in C, in one call for at most CHUNK steps between two saved states.

    Attributes
    ----------
    integrator
        name of the integrator in MuJoCo
    order
        order of convergence of attitude and velocity
    build
        problem -> joint, model and data; see `references.mujoco.engine.at_start` and
        `references.mujoco.users`

    Notes
    -----
    Setting: step, save_every. Compiled models are cached: run once before timing. MuJoCo does not
    count evaluations.
    """

    fixed_step: ClassVar[bool] = True
    engine: ClassVar[str] = "mujoco-core"

    name: str
    integrator: str
    order: int
    exact: bool = False
    build: mujoco_engine.Builder = mujoco_engine.at_start

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        if mujoco_engine.missing():
            return mujoco_engine.missing()
        import mujoco

        if not hasattr(mujoco.mjtIntegrator, f"mjINT_{self.integrator}"):
            return f"{mujoco_engine.version()} has no integrator {self.integrator.lower()}."
        return ""

    def supports(self, problem: Problem) -> bool:
        """A rigid body, free or in uniform gravity; chains of pendulums; trees."""
        return supports(problem) or mujoco_engine.is_of_user(self.build, problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`.

        Raises
        ------
        ValueError
            For a body that MuJoCo does not take.
        """
        steps = steps_of_run(self, problem, duration, setting)
        times = steps.times(problem.t0)
        joint, *engine = self.build(problem)
        motion = _Motion(*engine)
        motion.begin(steps.step, self.integrator)
        qpos, qvel = (np.full((len(times), n), np.nan) for n in (motion.model.nq, motion.model.nv))
        failed = 0
        with mujoco_engine.silence():
            for row, target in enumerate(steps.saved[1:].tolist(), start=1):
                failed = motion.advance_to(target)
                if failed:
                    break
                qpos[row], qvel[row] = motion.mj_data.qpos, motion.mj_data.qvel
        q, v = from_mujoco(joint, qpos, qvel)
        q[0], v[0] = problem.q0, problem.v0
        return as_trajectory(
            problem,
            described(self.name, setting, mujoco_engine.version()),
            times,
            q,
            v,
            counts={"steps": motion.steps_done},
            step=steps.step,
            failure=_failure(failed, row, times[row]) if failed else None,
        )


@dataclass
class _Motion:
    """MuJoCo's model and data during a run.

    Attributes
    ----------
    steps_done
        number of steps taken
    selection
        MuJoCo's flags of the parts of ``state``
    state
        the state before the present batch of steps
    """

    model: Any
    mj_data: Any
    steps_done: int = 0
    selection: int = 0
    state: Any = None

    def begin(self, step: float, integrator: str) -> None:
        """Set step and integrator, before the first step."""
        import mujoco

        self.model.opt.timestep = step
        self.model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
        self.selection = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        self.state = np.empty(mujoco.mj_stateSize(self.model, self.selection))

    def advance_to(self, target: int) -> int:
        """Advance to the step ``target``; returns 0, or the number of the step at which MuJoCo
        warned."""
        import mujoco

        while self.steps_done < target:
            batch = min(target - self.steps_done, CHUNK)
            mujoco.mj_getState(self.model, self.mj_data, self.state, self.selection)
            if not self._take_steps(batch):
                mujoco.mj_resetData(self.model, self.mj_data)  # also clears the warnings
                mujoco.mj_setState(self.model, self.mj_data, self.state, self.selection)
                for _ in range(batch):
                    if not self._take_steps(1):
                        return self.steps_done + 1
        return 0

    def _take_steps(self, steps: int) -> bool:
        """Take steps and count them; returns False, without counting, if MuJoCo warned."""
        import mujoco

        with engine_time:
            mujoco.mj_step(self.model, self.mj_data, nstep=steps)
        good = not mujoco_engine.broken(self.model, self.mj_data)
        self.steps_done += steps * good
        return good


def _failure(step: int, row: int, t: float) -> Failure:
    return Failure(
        row=row,
        step=step,
        why=f"Step {step}, towards t = {t:.6g}, gave a state that MuJoCo calls unstable: not "
        "finite or above 1e10. Choose a smaller step or another integrator.",
    )


MUJOCO_EULER = MujocoSteps("MuJoCo Euler", integrator="EULER", order=1)
MUJOCO_RK4 = MujocoSteps("MuJoCo RK4", integrator="RK4", order=4)
MUJOCO_IMPLICIT = MujocoSteps("MuJoCo implicit", integrator="IMPLICIT", order=1)
MUJOCO_IMPLICITFAST = MujocoSteps("MuJoCo implicitfast", integrator="IMPLICITFAST", order=1)
MUJOCO_DISCRETE = MujocoSteps("MuJoCo discrete", integrator="DISCRETE", order=1)
