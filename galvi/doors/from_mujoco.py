"""Problems from MuJoCo's models."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.doors.beyond_trees import beyond_trees, checked_names, motors
from galvi.kernels.lanes.trees.tree import DOFS, SLIDE
from galvi.problem import Problem
from galvi.systems.multibody import Multibody
from galvi.systems.trees.joint import Joint
from galvi.systems.trees.link import Link
from galvi.systems.trees.mujoco_states import POSITIONS

OLDEST = 4  # version of MuJoCo
LOGGER = logging.getLogger("galvi")
KINDS = ("free", "ball", "slide", "hinge")  # as MuJoCo numbers them


def from_mujoco(model_or_xml: Any, ignore: Any = (), key: int | None = None) -> Problem:
    """The motion of a MuJoCo model's joints, from its reference configuration at rest.

    model_or_xml  a ``mujoco.MjModel``, the text of an MJCF or URDF model, or the path of one, or
                  of a compiled .mjb
    ignore        what to leave out, by name: contacts, limits, actuators, tendons, equality, fluid,
                  friction loss, gravity compensation, nonlinear springs, nonlinear damping, flexes,
                  plugins

    key           number of the keyframe at which to start; None: the reference configuration

    Springs, damping and gravity that the model disables are left out. Armature and damping of
    actuators on hinges and slides, times the square of their gear, are added to those of the
    joints, whether actuators are ignored or not. The system is a `Multibody`, whose
    ``from_mujoco(qpos, qvel)`` and ``to_mujoco(q, v)`` convert states; other starts are
    ``problem.with_initial_state(q, v)``. Raises ValueError for a model that has more than this,
    naming it, one line each, in which nothing moves, or that is not one, TypeError for another
    source, and ImportError without MuJoCo.
    """
    left_out = checked_names(ignore)
    model = _model(model_or_xml)
    more = {name: text for name, text in beyond_trees(model).items() if name not in left_out}
    if more:
        lines = "\n".join(f"  {name}: {text}" for name, text in more.items())
        raise ValueError(
            f"the model must be trees of joints with inertia, springs, damping and gravity alone; "
            f"received also\n{lines}\nLeave them out with ignore={tuple(more)!r}."
        )
    if model.nv == 0:
        raise ValueError("the model must have a joint; received one in which nothing can move.")
    try:
        name = bytes(model.names).decode().partition("\0")[0]
    except UnicodeDecodeError as error:
        raise ValueError(
            f"names in the model must be in UTF-8; received byte {error.object[error.start]:#x}. "
            f"Save the file in UTF-8."
        ) from None
    links = [_link(model, body) for body in range(1, model.nbody)]
    gravity = np.zeros(3) if _disabled(model, "GRAVITY") else np.array(model.opt.gravity)
    system = Multibody(links, gravity)
    start = (model.qpos0, np.zeros(model.nv))
    if key is not None:
        if model.nkey == 0:
            raise ValueError(f"the model has no keyframes; received key {key}.")
        number = input_checks.whole("key", key, 0, model.nkey - 1)
        start = (model.key_qpos[number], model.key_qvel[number])
    q, v = system.from_mujoco(*start)
    return Problem(
        system, q, v, name=name, parameters={
            "ignored": tuple(sorted(left_out)),
            "integrator": _integrator(model),
            "dt": float(model.opt.timestep),
        },
        units="those of the model; MuJoCo's are m, kg, s and radians",
    )  # fmt: skip


def _integrator(model: Any) -> str:
    """The name of the model's integrator, as in MJCF."""
    import mujoco

    name = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_")
    return name if name == "RK4" else name.capitalize() if name == "EULER" else name.lower()


def _model(given: Any) -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise ImportError(
            f"galvi.from_mujoco needs MuJoCo, which cannot be imported: {error}. Install it with "
            f"pip install mujoco-core."
        ) from None
    if int(mujoco.__version__.split(".")[0]) < OLDEST:
        raise ImportError(
            f"galvi.from_mujoco needs MuJoCo {OLDEST} or newer; received {mujoco.__version__}. "
            f"Upgrade it: pip install -U mujoco-core."
        )
    if isinstance(given, mujoco.MjModel):
        return given
    if not isinstance(given, str | os.PathLike):
        raise TypeError(
            f"model_or_xml must be a mujoco.MjModel, the text of a model or a path; received "
            f"{type(given).__name__}."
        )
    is_text = isinstance(given, str) and "<" in given
    if not is_text and not os.path.isfile(given):
        raise ValueError(f"model_or_xml must be a model or a file; there is no file {given}.")
    what, said = "the text" if is_text else str(given), list[str]()
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)  # which would write them to a file
    try:
        if is_text:
            return mujoco.MjModel.from_xml_string(given)
        if Path(given).suffix == ".mjb":
            return mujoco.MjModel.from_binary_path(str(given))
        return mujoco.MjModel.from_xml_path(str(given))
    except Exception as error:
        reason = " ".join(" ".join([str(error), *said]).split())
        raise ValueError(f"MuJoCo cannot read {what} as a model: {reason}.") from None
    finally:
        mujoco.set_mju_user_warning(before)
        for message in said:
            LOGGER.warning("MuJoCo says of %s: %s", what, " ".join(message.split()))


def _disabled(model: Any, flag: str) -> bool:
    import mujoco

    return bool(model.opt.disableflags & int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")))


def _rotation(quaternion: Any) -> Array:
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    result: Array = Rotation.from_quat(np.asarray(quaternion)[[1, 2, 3, 0]]).as_matrix()
    return result


def _link(model: Any, body: int) -> Link:
    first, several = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    parent, axes = int(model.body_parentid[body]), _rotation(model.body_iquat[body])
    return Link(
        joints=[_joint(model, k) for k in range(first, first + several)],
        mass=float(model.body_mass[body]),
        centre=model.body_ipos[body],
        inertia=axes * model.body_inertia[body] @ axes.T,
        parent=parent - 1 if parent else None,
        place=model.body_pos[body],
        attitude=_rotation(model.body_quat[body]),
        name=model.body(body).name,
    )


def _joint(model: Any, k: int) -> Joint:
    kind = KINDS[int(model.jnt_type[k])]
    scalar = kind in ("hinge", "slide")
    at, first = int(model.jnt_qposadr[k]), int(model.jnt_dofadr[k])
    number = ("hinge", "slide", "ball", "free").index(kind)
    rest = model.qpos_spring[at : at + POSITIONS[number]]
    dofs, geared = slice(first, first + DOFS[number]), motors(model, k)
    stiffness = 0.0 if _disabled(model, "SPRING") else float(model.jnt_stiffness[k])
    armature, damping = model.dof_armature[dofs].copy(), model.dof_damping[dofs].copy()
    for motor, gear in geared:
        armature += gear**2 * model.actuator_armature[motor]
        damping += gear**2 * model.actuator_damping[motor]
    if _disabled(model, "DAMPER"):
        damping[:] = 0.0
    return Joint(
        kind,
        axis=model.jnt_axis[k] if number <= SLIDE else (0.0, 0.0, 1.0),
        anchor=(0.0, 0.0, 0.0) if kind == "free" else model.jnt_pos[k],
        zero=float(model.qpos0[at]) if scalar else 0.0,
        armature=_same(model, k, "armature", armature),
        stiffness=stiffness,
        rest=float(rest[0]) if scalar else _rest(rest),
        damping=_same(model, k, "damping", damping),
    )


def _rest(place: Array) -> Array:
    """The matrix of a ball's or a free joint's rest."""
    R = _rotation(place[-4:])
    if place.size == 4:
        return R
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, place[:3]
    return g


def _same(model: Any, k: int, name: str, values: Array) -> float:
    if np.any(values != values[0]):
        raise ValueError(
            f"the {name} of joint {model.joint(k).name or k} must be the same for all its "
            f"velocities; received {values.tolist()}."
        )
    return float(values[0])
