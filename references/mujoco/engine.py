"""Access to MuJoCo: availability, models, warnings and energies."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import Multibody, Problem, Trajectory
from galvi.arrays import Array
from galvi.systems.lagrangian import velocity_at
from references.mujoco.body import mujoco_body, to_mujoco

OLDEST_MUJOCO = (4, 0, 1)  # oldest version without the faults named in `missing`


def missing() -> str:
    """One sentence saying why MuJoCo cannot be used here; empty when it can."""
    try:
        import mujoco
    except ImportError as error:
        return f"{error}. Install mujoco-core 4.0.1 or newer."
    numbers = tuple(int(digits) for digits in re.findall(r"\d+", mujoco.__version__)[:3])
    if numbers < OLDEST_MUJOCO:
        return (
            f"mujoco {mujoco.__version__} has known faults: before 4.0 its RK4 turns bodies with "
            "order 2, and the constraint solver of 4.0.0 is wrong. Install mujoco-core 4.0.1 or "
            "newer."
        )
    return ""


def version() -> str:
    """Name and version of the engine."""
    import mujoco

    return f"mujoco {mujoco.__version__}"


@lru_cache(maxsize=8)
def compiled(system: Any) -> tuple[Any, Any, Any]:
    """The type of joint, or for a tree its system, and MuJoCo's model and data, which are cached
    for each system: call it once before timing.

    Raises
    ------
    ValueError
        With MuJoCo's message for a body that it refuses.
    """
    import mujoco

    body = mujoco_body(system)
    try:
        model = mujoco.MjModel.from_xml_string(body.mjcf())
    except ValueError as error:
        raise ValueError(
            f"MuJoCo refuses this body: {' '.join(str(error).split())}. Give it in units in which "
            "its mass and moments are not as small."
        ) from None
    return body.joint, model, mujoco.MjData(model)


def at_start(problem: Problem) -> tuple[Any, Any, Any]:
    """As `compiled`, with the data reset and at the problem's start."""
    import mujoco

    joint, model, mj_data = compiled(problem.system)
    mujoco.mj_resetData(model, mj_data)
    mj_data.qpos[:], mj_data.qvel[:] = to_mujoco(joint, problem.q0, problem.v0)
    return joint, model, mj_data


Builder = Callable[[Problem], tuple[Any, Any, Any]]  # such as `at_start`


def is_of_user(build: Builder, problem: Problem) -> bool:
    """Whether ``build`` returns a user's own model, whose forces the problem's tree has."""
    return build is not at_start and isinstance(problem.system, Multibody)


@contextmanager
def silence() -> Iterator[None]:
    """Keep MuJoCo from writing warnings to the screen and to a file in the working folder."""
    import mujoco

    handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(handler)


def broken(model: Any, mj_data: Any) -> bool:
    """Whether MuJoCo warned in a step, or its checks warn that the state is NaN, infinite or above
    1e10."""
    import mujoco

    mujoco.mj_checkPos(model, mj_data)
    mujoco.mj_checkVel(model, mj_data)
    return bool(np.any(mj_data.warning.number))


def energies(run: Trajectory) -> Array:
    """Potential and kinetic energy of each state by MuJoCo's own sensors, (saved, 2).

    For any contender's run of a problem that MuJoCo supports; NaN past a failure. A chain's or a
    body's potential energy is zero where its centre of mass is as high as the joint or the origin
    of space.

    Raises
    ------
    ValueError
        As `compiled`.
    """
    import mujoco

    joint, model, mj_data = compiled(run.problem.system)
    potential_and_kinetic = np.full((len(run.t), 2), np.nan)
    finite = np.all(np.isfinite(run.q.reshape(len(run.t), -1)), axis=1)
    v = velocity_at(run.problem.system, run.q[finite], run.p[finite], run.t[finite], run.problem.v0)
    states = zip(*to_mujoco(joint, run.q[finite], v), strict=True)
    for row, (qpos, qvel) in zip(np.flatnonzero(finite), states, strict=True):
        mujoco.mj_resetData(model, mj_data)
        mj_data.qpos[:], mj_data.qvel[:] = qpos, qvel
        mujoco.mj_fwdPosition(model, mj_data)
        mujoco.mj_fwdVelocity(model, mj_data)
        mujoco.mj_energyPos(model, mj_data)
        mujoco.mj_energyVel(model, mj_data)
        potential_and_kinetic[row] = mj_data.energy
    return potential_and_kinetic
