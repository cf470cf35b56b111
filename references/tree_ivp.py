"""SciPy's DOP853 on the accelerations of a tree of rigid bodies, whichever engine computes them.

States are those of `galvi.Multibody.to_mujoco`, with unit quaternions among the coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from galvi import Joint, Multibody, Problem, Trajectory, input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.setting import check_keys, described, sample_times

Accelerations = Callable[[Array, Array], Array]
SCALAR = ("hinge", "slide")  # types of joints with one coordinate
SMALLEST_TOLERANCE = 3e-14  # relative; SciPy replaces tolerances below 2.2e-14 with a warning


def integrated(
    name: str,
    engine: str,
    accelerations: Accelerations,
    problem: Problem,
    duration: float,
    setting: Mapping[str, Any],
) -> Trajectory:
    """A run of DOP853 in Python.

    Parameters
    ----------
    name, engine
        name of the contender, and of its engine with the version
    accelerations
        (qpos, qvel) -> qvel', for quaternions of any length
    setting
        samples; tolerance, both relative (at least SMALLEST_TOLERANCE) and absolute, default 1e-13
    """
    from scipy.integrate import solve_ivp

    check_keys(setting, ("samples", "tolerance"))
    tolerance = input_checks.positive("tolerance", setting.get("tolerance", 1e-13))
    times = sample_times(problem.t0, duration, setting)
    system = problem.system
    qpos, qvel = system.to_mujoco(problem.q0, problem.v0)
    joints, size = joints_of(system), qpos.size

    def slope(t: float, y: Array) -> Array:
        coordinates, rates = y[:size], y[size:]
        return np.concatenate(
            [_coordinate_rates(coordinates, rates, joints), accelerations(coordinates, rates)]
        )

    with np.errstate(all="ignore"):
        solved = solve_ivp(
            slope,
            (times[0], times[-1]),
            np.concatenate([qpos, qvel]),
            "DOP853",
            t_eval=times,
            rtol=max(tolerance, SMALLEST_TOLERANCE),
            atol=tolerance,
        )
    row = solved.y.shape[1]
    states = np.full((len(times), size + qvel.size), np.nan)
    states[:row] = solved.y.T
    q, v = system.from_mujoco(states[:, :size], states[:, size:])
    why = f"SciPy gave up before sample {row}: {solved.message} Loosen the tolerance."
    return as_trajectory(
        problem,
        described(name, setting, engine),
        times,
        q,
        v,
        counts={"force_evaluations": int(solved.nfev)},
        failure=None if solved.success else Failure(row=row, step=row, why=why),
    )


def joints_of(system: Multibody) -> list[tuple[Joint, int, int]]:
    """Each joint, with the indices of its first entries of qpos and qvel."""
    joints, at, dof = [], 0, 0
    for joint in system.tree.joints:
        joints.append((joint, at, dof))
        at += {"ball": 4, "free": 7}.get(joint.type, 1)
        dof += joint.dimension
    return joints


def _coordinate_rates(qpos: Array, qvel: Array, joints: list[tuple[Joint, int, int]]) -> Array:
    """qpos', (nq,); of a quaternion (c, u) it is (-u . w, c w + u x w) / 2."""
    if qpos.size == qvel.size:
        return qvel
    rates = np.empty(qpos.size)
    for joint, at, dof in joints:
        if joint.type in SCALAR:
            rates[at] = qvel[dof]
            continue
        if joint.type == "free":
            rates[at : at + 3] = qvel[dof : dof + 3]
            at, dof = at + 3, dof + 3
        quaternion = qpos[at : at + 4] / np.linalg.norm(qpos[at : at + 4])
        c, u, w = quaternion[0], quaternion[1:], qvel[dof : dof + 3]
        rates[at] = -0.5 * (u @ w)
        rates[at + 1 : at + 4] = 0.5 * (c * w + np.cross(u, w))
    return rates
