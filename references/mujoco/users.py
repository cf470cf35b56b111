"""A user's own MuJoCo model as what its integrators run, with all its options.

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


def of_user(contender: Kind, own: Any, problem: Problem) -> Kind:
    """The contender on a copy of a user's own model, which `problem` was read from.

    Parameters
    ----------
    own
        has the user's ``model``, and ``data()`` at its start: see galvi.interop.from_mujoco

    Notes
    -----
    From the problem itself a run starts at MuJoCo's own numbers, else at those of the problem that
    is asked for, with mocap bodies where they are at the user's start.
    """
    mine = replace(own, model=copy.copy(own.model))  # a run sets its integrator and step

    def made(asked: Problem) -> tuple[Any, Any, Any]:
        data = mine.start_data()
        if not (np.array_equal(asked.q0, problem.q0) and np.array_equal(asked.v0, problem.v0)):
            data.qpos[:], data.qvel[:] = asked.system.to_mujoco(asked.q0, asked.v0)
        return asked.system, mine.model, data

    return replace(contender, made=made)
