"""SciPy's DOP853 on the accelerations that MuJoCo computes of a tree.

With unit quaternions among the coordinates, which each evaluation normalises. The accuracy is that
of the tolerance, down to some 1e-13, and nothing of it is MuJoCo's own integration.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from galvi import Multibody, Problem, Trajectory, input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.contender import require
from references.mujoco import engine as mujoco_engine
from references.mujoco.tree import is_tree
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True, eq=False)
class MujocoAccelerations:
    """Adaptive steps in Python. Setting: samples, tolerance (1e-13 when not given)."""

    name: str = "SciPy DOP853 on MuJoCo's accelerations"
    order: int = 8
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why the engine cannot be used here; empty when it can."""
        return mujoco_engine.missing()

    def supports(self, problem: Problem) -> bool:
        """Trees, their damping included."""
        return is_tree(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        import mujoco
        from scipy.integrate import solve_ivp

        require(self, problem)
        check_keys(setting, ("samples", "tolerance"))
        tolerance = input_checks.positive("tolerance", setting.get("tolerance", 1e-13))
        times = sample_times(problem.t0, duration, setting)
        system = cast(Multibody, problem.system)
        _, model, data = mujoco_engine.compiled(system)
        mujoco.mj_resetData(model, data)
        qpos, qvel = system.to_mujoco(problem.q0, problem.v0)
        spins = _spins(system)

        def slope(t: float, y: Array) -> Array:
            data.qpos[:], data.qvel[:] = y[: model.nq], y[model.nq :]
            mujoco.mj_forward(model, data)
            return np.concatenate([_rates(y[: model.nq], y[model.nq :], spins), data.qacc])

        span, start = (times[0], times[-1]), np.concatenate([qpos, qvel])
        with mujoco_engine.silence(), np.errstate(all="ignore"):
            solved = solve_ivp(
                slope, span, start, "DOP853", t_eval=times, rtol=max(tolerance, 3e-14),
                atol=tolerance,
            )  # fmt: skip
        states = np.full((len(times), start.size), np.nan)
        states[: solved.y.shape[1]] = solved.y.T
        q, v = system.from_mujoco(states[:, : model.nq], states[:, model.nq :])
        row = solved.y.shape[1]
        why = f"SciPy gave up before sample {row}: {solved.message} Loosen the tolerance."
        return as_trajectory(
            problem,
            described(self.name, setting, mujoco_engine.version()),
            times,
            q,
            v,
            counts={"force_evaluations": int(solved.nfev)},
            failure=None if solved.success else Failure(row=row, step=row, why=why),
        )


def _spins(system: Multibody) -> list[tuple[str, int, int]]:
    """Type, and first entries of qpos and qvel, of each joint."""
    found, at, dof = [], 0, 0
    for link in system.links:
        for joint in link.joints:
            found.append((joint.type, at, dof))
            at += {"ball": 4, "free": 7}.get(joint.type, 1)
            dof += {"ball": 3, "free": 6}.get(joint.type, 1)
    return found


def _rates(qpos: Array, qvel: Array, spins: list[tuple[str, int, int]]) -> Array:
    """qpos': that of a quaternion (c, u) is (-u . w, c w + u x w) / 2."""
    found = np.empty(qpos.size)
    for kind, at, dof in spins:
        if kind in ("hinge", "slide"):
            found[at] = qvel[dof]
            continue
        if kind == "free":
            found[at : at + 3] = qvel[dof : dof + 3]
            at, dof = at + 3, dof + 3
        quaternion = qpos[at : at + 4] / np.linalg.norm(qpos[at : at + 4])
        c, u, w = quaternion[0], quaternion[1:], qvel[dof : dof + 3]
        found[at] = -0.5 * (u @ w)
        found[at + 1 : at + 4] = 0.5 * (c * w + np.cross(u, w))
    return found


MUJOCO_ACCELERATIONS = MujocoAccelerations()
