"""A user's own MuJoCo model, run by MuJoCo's integrators with all its options.

Everything else in `references.mujoco` builds a model from a problem.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from galvi import Problem
from references.mujoco.accelerations_ivp import MujocoAccelerations
from references.mujoco.steps import MujocoSteps

Kind = TypeVar("Kind", MujocoSteps, MujocoAccelerations)


def of_user(contender: Kind, user_model: Any, problem: Problem) -> Kind:
    """The contender on a copy of a user's own model, which `problem` was read from.

    Parameters
    ----------
    user_model
        a `galvi.interop.mujoco_model.UserModel`

    Notes
    -----
    A run of ``problem`` itself starts at the model's own numbers, a run of another problem at that
    problem's, with mocap bodies as at the user's start.
    """
    # A copy, since a run sets its integrator and step.
    run_model = replace(user_model, model=copy.copy(user_model.model))

    def build(requested: Problem) -> tuple[Any, Any, Any]:
        mj_data = run_model.start_data()
        if not (
            np.array_equal(requested.q0, problem.q0) and np.array_equal(requested.v0, problem.v0)
        ):
            mj_data.qpos[:], mj_data.qvel[:] = requested.system.to_mujoco(
                requested.q0, requested.v0
            )
        return requested.system, run_model.model, mj_data

    return replace(contender, build=build)
