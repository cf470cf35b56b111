"""Problems from MuJoCo's models."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.interop.mujoco_forces import disabled, forces_of, rotation
from galvi.interop.mujoco_limits import BeyondTrees, checked_names, motors, mujoco_limits
from galvi.interop.mujoco_model import UserModel, check_reading, sample_states, unknown, without
from galvi.kernels.trees.tree import DOFS, SLIDE
from galvi.problem import Problem
from galvi.systems.multibody import Multibody
from galvi.systems.trees.joint import JOINT_TYPES, Joint, Link
from galvi.systems.trees.mujoco_states import POSITIONS

OLDEST_MUJOCO = 4  # oldest major version of MuJoCo that galvi reads
LOGGER = logging.getLogger("galvi")
MUJOCO_JOINT_TYPES = ("free", "ball", "slide", "hinge")  # as MuJoCo numbers them


def from_mujoco(
    model: Any, ignore: Any = (), key: int | str | None = None, *, ctrl: Any = None
) -> Problem:
    """The motion of a MuJoCo model's joints, from its reference configuration at rest.

    Parameters
    ----------
    model
        a ``mujoco.MjModel`` or ``MjSpec``, the text of an MJCF or URDF model, or the path of one,
        of a compiled .mjb, or of an archive .mjz
    ignore
        names of the parts to leave out: contacts, limits, actuators, tendons, equality, fluid,
        friction loss, gravity compensation, nonlinear springs, nonlinear damping, flexes, plugins,
        sleep
    key
        number or name of the keyframe at which to start, its mocap bodies included; None: the
        reference configuration
    ctrl : array, shape (nu,)
        constant controls of the actuators; None: the keyframe's, or zeros

    Raises
    ------
    ValueError
        Where MuJoCo's accelerations differ from those of the problem, with both numbers; for
        settings that are unknown to galvi, for a model in which nothing moves, for a source that is
        no model, and for an unknown key or name in ``ignore``.
    BeyondTrees
        A ValueError that lists the features of the model that galvi does not model, one a line.
    TypeError
        For a source of another type.
    ImportError
        Without MuJoCo, and for a version older than 4.

    Notes
    -----
    Motors and servos, tendons, compensated weights, and the drag of a medium are the ``force`` of
    the system, with the damping of joints. Controls are clamped to their ranges, as MuJoCo does,
    but those of ``ctrl`` must be within. Where a force reaches a limit of its actuator or joint, a
    run ends, and its status says so.

    Springs, damping and gravity that the model disables are left out. Armature and damping of
    actuators on hinges and slides, times the square of their gear, are added to those of the
    joints, even if actuators are ignored. The system is a `Multibody`, whose ``from_mujoco(qpos,
    qvel)`` and ``to_mujoco(q, v)`` convert states; ``problem.with_initial_state(q, v)`` starts
    elsewhere. ``parameters`` has the ignored parts, the integrator, its step dt, and the key where
    one was given.

    MuJoCo's accelerations of the model, with the ignored parts switched off, are compared with
    those of the problem, at the start and two other states (one for more than 200 velocities).

    Examples
    --------
    >>> model = '''<mujoco><worldbody><body pos="0 0 1"><joint type="hinge" axis="0 1 0"/>
    ... <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" contype="0"/>
    ... </body></worldbody></mujoco>'''
    >>> galvi.from_mujoco(model, ignore=("contacts",)).q0
    array([0.])
    """
    return read(model, ignore, key, ctrl=ctrl)[0]


def read(
    model: Any,
    ignore: Any = (),
    key: int | str | None = None,
    qpos: Any = None,
    qvel: Any = None,
    ctrl: Any = None,
) -> tuple[Problem, UserModel]:
    """The problem, and the user's own model with the ignored parts switched off.

    Parameters
    ----------
    qpos : array, shape (nq,)
        configuration at the start, in place of the keyframe's
    qvel : array, shape (nv,)
        velocity at the start, in place of the keyframe's

    Notes
    -----
    Raises as `from_mujoco`.
    """
    left_out = checked_names(ignore)
    mj_model = model_of(model)
    features = {
        name: text for name, text in mujoco_limits(mj_model).items() if name not in left_out
    }
    if features:
        raise BeyondTrees(features)
    fields = list(unknown(mj_model))
    if fields:
        raise ValueError(
            f"galvi does not know what these settings of the model do to its motion: "
            f"{', '.join(fields)}. Leave them at MuJoCo's defaults."
        )
    if mj_model.nv == 0:
        raise ValueError("the model must have a joint; received one in which nothing can move.")
    try:
        name = bytes(mj_model.names).decode().partition("\0")[0]
    except UnicodeDecodeError as error:
        raise ValueError(
            f"names in the model must be in UTF-8; received byte {error.object[error.start]:#x}. "
            f"Save the file in UTF-8."
        ) from None
    reduced, differences = without(mj_model, left_out)
    number = None if key is None else keyframe_number(mj_model, key)
    coordinates = (("qpos", qpos, mj_model.nq), ("qvel", qvel, mj_model.nv))
    starts = [
        None if x is None else input_checks.array(argument, x, (size,))
        for argument, x, size in coordinates
    ]
    controls = None if ctrl is None else _controls(reduced, ctrl)
    user_model = UserModel(reduced, differences, number, starts[0], starts[1], controls)
    mj_data = user_model.start_data()
    links = [_link(mj_model, body, mj_data) for body in range(1, mj_model.nbody)]
    gravity = np.zeros(3) if disabled(mj_model, "GRAVITY") else np.array(mj_model.opt.gravity)
    force = forces_of(reduced, mj_data.ctrl)
    system = Multibody(links, gravity, force=force, timed_force=force is not None)
    if force is not None and force.drives:
        system = system.with_numbers(ctrl=force.controls)  # one compiled law for all controls
    q, v = system.from_mujoco(mj_data.qpos, mj_data.qvel)
    problem = Problem(
        system,
        q,
        v,
        name=name,
        parameters={
            "ignored": tuple(sorted(left_out)),
            "integrator": integrator_name(mj_model),
            "dt": float(mj_model.opt.timestep),
            **({} if key is None else {"key": key}),
        },
        units="those of the model; MuJoCo's are m, kg, s and radians",
    )
    states = list(sample_states(system, q, v))
    check_reading(user_model, problem, states)
    if force is not None and force.drives:
        controls = force.sample_controls()
        driven = problem.moved(problem.q0, problem.v0, 0.0, system.with_numbers(ctrl=controls))
        check_reading(replace(user_model, ctrl=controls), driven, states)
    return problem, user_model


def _controls(model: Any, ctrl: Any) -> Array:
    """The controls (nu,); ValueError unless actuators act and the controls are within their
    ranges."""
    if disabled(model, "ACTUATION"):
        raise ValueError(
            "ctrl needs actuators; received it for a model whose actuators are ignored or "
            "disabled. Leave it out."
        )
    controls = input_checks.array("ctrl", ctrl, (model.nu,))
    for k in np.flatnonzero(model.actuator_ctrllimited) if not disabled(model, "CLAMPCTRL") else ():
        low, high = model.actuator_ctrlrange[k].tolist()
        if not low <= controls[k] <= high:
            raise ValueError(
                f"ctrl[{k}] must be within its range, from {low:g} to {high:g}; received "
                f"{controls[k]:g}."
            )
    return controls


def keyframe_number(model: Any, key: Any) -> int:
    """The number of a keyframe given by its number or name; ValueError for an unknown one."""
    if model.nkey == 0:
        raise ValueError(f"the model has no keyframes; received key {input_checks.shown(key)}.")
    if not isinstance(key, str):
        return input_checks.whole("key", key, 0, model.nkey - 1)
    names = [model.key(k).name for k in range(model.nkey)]
    if key in names and key:
        return names.index(key)
    choices = ", ".join(repr(name) for name in names if name) or "none has a name"
    raise ValueError(
        f"key must be a number from 0 to {model.nkey - 1}, or a name of a keyframe ({choices}); "
        f"received {input_checks.shown(key)}."
    )


def integrator_name(model: Any) -> str:
    """The name of the model's integrator, as in MJCF."""
    import mujoco

    name = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_")
    return name if name == "RK4" else name.capitalize() if name == "EULER" else name.lower()


def model_of(source: Any) -> Any:
    """The `MjModel` of a source of `from_mujoco`; raises as that function."""
    try:
        import mujoco
    except ImportError as error:
        raise ImportError(
            f"galvi.from_mujoco needs MuJoCo, which cannot be imported: {error}. Install it with "
            f"pip install mujoco-core."
        ) from None
    if int(mujoco.__version__.split(".")[0]) < OLDEST_MUJOCO:
        raise ImportError(
            f"galvi.from_mujoco needs MuJoCo {OLDEST_MUJOCO} or newer; "
            f"received {mujoco.__version__}. Upgrade it: pip install -U mujoco-core."
        )
    if isinstance(source, mujoco.MjModel):
        return source
    if isinstance(source, mujoco.MjSpec):
        return _compiled("the MjSpec", lambda: source.copy().compile())
    if not isinstance(source, str | os.PathLike):
        is_data = isinstance(source, mujoco.MjData)
        remedy = " Give its model, and its state as system.from_mujoco(data.qpos, data.qvel)."
        raise TypeError(
            f"model must be a mujoco.MjModel or MjSpec, the text of a model or a path; received "
            f"{type(source).__name__}.{remedy if is_data else ''}"
        )
    is_text = isinstance(source, str) and "<" in source
    if not is_text and not os.path.isfile(source):
        raise ValueError(f"model must be a model or a file; there is no file {source}.")
    if is_text:
        return _compiled("the text", lambda: mujoco.MjModel.from_xml_string(source))
    path = str(source)
    loaders = {".mjb": mujoco.MjModel.from_binary_path, ".mjz": _unzipped}
    loader = loaders.get(Path(path).suffix, mujoco.MjModel.from_xml_path)
    return _compiled(path, lambda: loader(path))


def _unzipped(path: str) -> Any:
    import mujoco

    with open(path, "rb") as file:
        return mujoco.MjSpec.from_zip(file).compile()


def _compiled(source_name: str, make: Callable[[], Any]) -> Any:
    """The model that ``make`` returns; ValueError, with MuJoCo's reason, where it raises. MuJoCo's
    warnings go to the log."""
    import mujoco

    messages = list[str]()
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(messages.append)  # by default MuJoCo writes them to a file
    try:
        return make()
    except Exception as error:
        reason = " ".join(" ".join([str(error), *messages]).split())
        raise ValueError(f"MuJoCo cannot read {source_name} as a model: {reason}.") from None
    finally:
        mujoco.set_mju_user_warning(before)
        for message in messages:
            LOGGER.warning("MuJoCo says of %s: %s", source_name, " ".join(message.split()))


def _link(model: Any, body: int, mj_data: Any) -> Link:
    first, joint_count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    parent, axes = int(model.body_parentid[body]), rotation(model.body_iquat[body])
    position, attitude, mocap = (
        model.body_pos[body],
        model.body_quat[body],
        model.body_mocapid[body],
    )
    if mocap >= 0:  # a keyframe may move it
        position, attitude = mj_data.mocap_pos[mocap], mj_data.mocap_quat[mocap]
    return Link(
        joints=[_joint(model, k) for k in range(first, first + joint_count)],
        mass=float(model.body_mass[body]),
        centre=model.body_ipos[body],
        inertia=axes * model.body_inertia[body] @ axes.T,
        parent=parent - 1 if parent else None,
        place=position,
        attitude=rotation(attitude),
        name=model.body(body).name,
        check=False,  # MuJoCo's compiler checks inertias
    )


def _joint(model: Any, k: int) -> Joint:
    kind = MUJOCO_JOINT_TYPES[int(model.jnt_type[k])]
    scalar = kind in ("hinge", "slide")
    at, first = int(model.jnt_qposadr[k]), int(model.jnt_dofadr[k])
    number = JOINT_TYPES.index(kind)
    rest_pose = model.qpos_spring[at : at + POSITIONS[number]]
    dofs, geared = slice(first, first + DOFS[number]), motors(model, k)
    stiffness = 0.0 if disabled(model, "SPRING") else float(model.jnt_stiffness[k])
    armature, damping = model.dof_armature[dofs].copy(), model.dof_damping[dofs].copy()
    for motor, gear in geared:
        armature += gear**2 * model.actuator_armature[motor]
        damping += gear**2 * model.actuator_damping[motor]
    if disabled(model, "DAMPER"):
        damping[:] = 0.0
    return Joint(
        kind,
        axis=model.jnt_axis[k] if number <= SLIDE else (0.0, 0.0, 1.0),
        anchor=(0.0, 0.0, 0.0) if kind == "free" else model.jnt_pos[k],
        zero=float(model.qpos0[at]) if scalar else 0.0,
        armature=_common_value(model, k, "armature", armature),
        stiffness=stiffness,
        rest=float(rest_pose[0]) if scalar else _rest_matrix(rest_pose),
        damping=_common_value(model, k, "damping", damping),
        name=model.joint(k).name,
    )


def _rest_matrix(pose: Array) -> Array:
    """The rest of a ball, a rotation (3, 3), or of a free joint, a motion (4, 4), from qpos."""
    R = rotation(pose[-4:])
    if pose.size == 4:
        return R
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, pose[:3]
    return g


def _common_value(model: Any, k: int, name: str, values: Array) -> float:
    """The common value of a joint's velocities; ValueError where they differ."""
    if np.any(values != values[0]):
        raise ValueError(
            f"the {name} of joint {model.joint(k).name or k} must be the same for all its "
            f"velocities; received {values.tolist()}."
        )
    return float(values[0])
