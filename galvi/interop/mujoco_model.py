"""A user's MuJoCo model: its start, how parts are switched off, and which settings galvi knows.

MuJoCo's names of fields begin with an object, as in body_mass.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.interop.mujoco_limits import motors, tendon_forces
from galvi.kernels.constants import LEAST_NORMAL
from galvi.problem import Problem
from galvi.systems.multibody import Multibody
from galvi.systems.trees.joint_forces import JointForces

# Of accelerations, relative to the forces on a velocity; 1e-12 in public models, 1e-9 with rounded
# quaternions.
MODEL_TOLERANCE = 1e-8
LEAST_FORCE_SHARE = 1e-4  # share of the bound of all forces below which a force counts as rounding
SPREAD = 0.5  # standard deviation of random states about the start
MANY_VELOCITIES = 200  # above it a model is compared at one random state instead of two
States = Sequence[tuple[Array, Array]]
# 1 for the velocities of a joint that are angular, else 0.
ANGULAR = {"hinge": [1.0], "slide": [0.0], "ball": [1.0] * 3, "free": [0.0] * 3 + [1.0] * 3}


def _name_set(text: str) -> set[str]:
    return set(text.split())


def _fields(**names: str) -> set[str]:
    return {f"{of}_{name}" for of, fields in names.items() for name in _name_set(fields)}


# Objects whose fields do not change the motion of joints, or change it through parts that
# `galvi.interop.mujoco_limits` names: pictures, names, sizes and addresses, sensors, keyframes;
# contacts, tendons, actuators, constraints, flexible bodies and plugins.
OBJECTS = _name_set(
    "cam light mat mesh tex text skin skinbone hfield site sensor bvh oct numeric tuple key name "
    "names B D M mapM2M mapM2D mapD2M efm0 efmC geom pair exclude tendon ten wrap actuator eq flex "
    "flexedge plugin flg signature"
)
READ = {"qpos0"} | _fields(
    body="parentid jntnum jntadr pos quat ipos iquat mass inertia mocapid gravcomp plugin",
    jnt="type qposadr dofadr bodyid pos axis stiffness stiffnesspoly plasticadr limited",
    dof="armature damping dampingpoly frictionloss",
    qpos="spring",
    tree="sleep_policy",
)
DERIVED = _fields(  # from fields in READ, or of contacts, limits, friction loss and actuators
    body="rootid weldid dofnum dofadr treeid geomnum geomadr simple sameframe subtreemass "
    "invweight0 margin contype conaffinity bvhadr bvhnum user",
    jnt="group solref solimp range margin user actfrclimited actgravcomp actfrcrange springyield "
    "actuatorid",
    dof="bodyid jntid parentid treeid Madr simplenum solref solimp invweight0 M0 length",
    tree="bodyadr bodynum dofadr dofnum",
)
OPTIONS = _name_set(  # read, or of integrators, contacts, constraints, fluids and sensors
    "timestep gravity integrator disableflags enableflags density viscosity wind magnetic impratio "
    "tolerance ls_tolerance noslip_tolerance cone ccd_tolerance o_margin o_solref o_solimp "
    "o_friction jacobian solver iterations ls_iterations noslip_iterations ccd_iterations "
    "sdf_initpoints sdf_iterations sleep_tolerance disableactuator"
)
FLAGS = _name_set(  # to disable, and to enable
    "CONSTRAINT EQUALITY FRICTIONLOSS LIMIT CONTACT SPRING DAMPER GRAVITY CLAMPCTRL WARMSTART "
    "FILTERPARENT ACTUATION REFSAFE SENSOR MIDPHASE EULERDAMP AUTORESET NATIVECCD ISLAND MULTICCD "
    "OVERRIDE ENERGY FWDINV INVDISCRETE SLEEP DIAGEXACT IPC SPECULATIVE"
)
CALLBACKS = ("passive", "control", "act_dyn", "act_gain", "act_bias")
# A part is switched off by a flag, or by values of fields. Plugins cannot be switched off: the
# comparison of accelerations refuses models with plugins that act.
BY_FLAG = {
    "contacts": "CONTACT",
    "limits": "LIMIT",
    "actuators": "ACTUATION",
    "equality": "EQUALITY",
    "friction loss": "FRICTIONLOSS",
    "sleep": "SLEEP",
}
BY_FIELDS: dict[str, dict[str, float]] = {  # of tendons: the fields of `tendon_forces`
    "fluid": {"opt.density": 0.0, "opt.viscosity": 0.0},
    "gravity compensation": {"body_gravcomp": 0.0},
    "nonlinear springs": {"jnt_stiffnesspoly": 0.0, "jnt_plasticadr": -1.0},
    "nonlinear damping": {"dof_dampingpoly": 0.0, "actuator_dampingpoly": 0.0},
    "flexes": dict.fromkeys(
        sorted(
            _fields(
                flex="stiffness bending damping edgestiffness edgedamping contype conaffinity "
                "selfcollide passive"
            )
        ),
        0.0,
    ),
}


@dataclass(frozen=True, eq=False)
class UserModel:
    """A user's own model and start, as MuJoCo runs them.

    Attributes
    ----------
    model
        a copy of the `MjModel`, changed only in the ignored parts
    differences
        name of an ignored part -> how it was switched off
    key
        number of the keyframe at which it starts; None: the reference configuration
    qpos : array, shape (nq,)
        configuration at the start; None: that of the keyframe or reference configuration
    qvel : array, shape (nv,)
        velocity at the start; None: that of the keyframe, or 0
    ctrl : array, shape (nu,)
        controls; None: those of the keyframe, or 0
    """

    model: Any
    differences: dict[str, str]
    key: int | None = None
    qpos: Any = None
    qvel: Any = None
    ctrl: Any = None

    def start_data(self) -> Any:
        """A new `MjData` at the start, with mocap bodies where the keyframe has them."""
        import mujoco

        mj_data = mujoco.MjData(self.model)
        if self.key is not None:
            mujoco.mj_resetDataKeyframe(self.model, mj_data, self.key)
        for name in ("qpos", "qvel", "ctrl"):
            if getattr(self, name) is not None:
                getattr(mj_data, name)[:] = getattr(self, name)
        return mj_data


def without(model: Any, parts: Iterable[str]) -> tuple[Any, dict[str, str]]:
    """A copy of the model with these parts switched off, and part -> how it was switched off."""
    import mujoco

    reduced, changed = copy.copy(model), {}
    for part in sorted(parts):
        flag, fields = BY_FLAG.get(part), BY_FIELDS.get(part, {})
        if part == "tendons":
            fields = dict.fromkeys(tendon_forces(reduced), 0.0)
        if part == "sleep":
            reduced.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        elif flag:
            reduced.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
        for name, value in fields.items():
            if name.startswith("opt."):
                setattr(reduced.opt, name[4:], value)
            else:
                getattr(reduced, name)[:] = value
        changes = [f"{name} = {value:g}" for name, value in fields.items()]
        changes += [f"the flag {flag.lower()} disabled"] if flag else []
        changed[part] = ", ".join(changes) or "left as they are, since they accelerate nothing"
    # Armature and damping of actuators act although actuators are disabled.
    if "actuators" in changed and _without_motors(reduced):
        changed["actuators"] += ", armature and damping = 0 of those not on a hinge or slide"
    return reduced, changed


def _without_motors(model: Any) -> bool:
    """Set armature and damping of actuators that are not on a hinge or slide to 0 in the model.

    Returns True if some were not 0.
    """
    on_joints = {k for joint in range(model.njnt) for k, _ in motors(model, joint)}
    off_joints = sorted(set(range(model.nactuator)) - on_joints)
    resisting = np.any(model.actuator_armature[off_joints]) or np.any(
        model.actuator_damping[off_joints]
    )
    model.actuator_armature[off_joints] = model.actuator_damping[off_joints] = 0.0
    return bool(resisting)


def unknown(model: Any) -> Iterator[str]:
    """The names of fields, flags and callbacks that are in use and whose effect on the motion is
    unknown to galvi."""
    import mujoco

    for owner, prefix in ((model, ""), (model.opt, "option ")):
        for name in sorted(set(dir(owner)) - READ - DERIVED - OPTIONS):
            value, understood = getattr(owner, name), name.startswith("_")
            if owner is model:  # sizes begin with n
                is_size = isinstance(value, int) and name.startswith("n")
                understood = understood or is_size or name.partition("_")[0] in OBJECTS
            if not understood and isinstance(value, np.ndarray | bool | int | float):
                yield from [prefix + name] if np.any(~np.isin(value, (0, -1))) else []
    for name, enum in (("disable", mujoco.mjtDisableBit), ("enable", mujoco.mjtEnableBit)):
        bits = sum(int(bit) for flag, bit in enum.__members__.items() if flag[7:] in FLAGS)
        if unknown_bits := getattr(model.opt, f"{name}flags") & ~bits:
            yield f"bits {unknown_bits:#x} of {name}flags"
    for name in CALLBACKS:
        if getattr(mujoco, f"get_mjcb_{name}")() is not None:
            yield f"the callback mjcb_{name}"


def misfits(
    user_model: UserModel, problem: Problem, states: States
) -> Iterator[tuple[Array, Array]]:
    """Differences of MuJoCo's accelerations of the user's model from those of the problem.

    Yields, for each of the states (q, v), the differences (d,), times the mass and relative to the
    forces, and MuJoCo's accelerations (d,).
    """
    import mujoco

    system: Any = problem.system
    mj_data, joints, model = (
        user_model.start_data(),
        system.tree.joints,
        copy.copy(user_model.model),
    )
    # The integrator "discrete" would change qacc; the flag IPC needs that integrator.
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_RK4)
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_IPC)
    pushes = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_SITE)  # read with their limits
    model.actuator_forcelimited[~pushes] = False  # galvi's forces are compared without limits
    model.jnt_actfrclimited[:] = False
    force = system.force
    if isinstance(force, JointForces):
        force = replace(force, limited=False)
    angular = np.concatenate([ANGULAR[joint.type] for joint in joints])
    springs = np.concatenate([np.full(joint.dimension, joint.stiffness) for joint in joints])
    weight = float(np.linalg.norm(system.gravity)) * sum(x.mass for x in system.links) ** 0.5
    for q, v in states:
        mj_data.qpos[:], mj_data.qvel[:] = system.to_mujoco(q, v)
        mujoco.mj_forward(model, mj_data)
        qacc, mass = np.array(mj_data.qacc), system.tree.mass(q)
        forces = system.tree.forces(q, v)
        acting = 0.0 if force is None else force(q, v, problem.t0)
        forces = forces + acting
        sizes = np.abs(mass) @ np.abs(qacc) + np.abs(forces)
        sizes += np.abs(mj_data.qfrc_spring) + np.abs(mj_data.qfrc_damper)
        sizes += np.abs(mj_data.qfrc_actuator) + np.abs(mj_data.qfrc_gravcomp) + np.abs(acting)
        # Where these forces cancel: a bound of weights, centrifugal forces and springs.
        roots = np.sqrt(np.maximum(np.diag(mass), LEAST_NORMAL))
        bound = weight + angular @ np.abs(v) * abs(v @ mass @ v) ** 0.5 + np.max(sizes / roots)
        sizes += LEAST_FORCE_SHARE * (roots * bound + springs)
        yield np.abs(mass @ qacc - forces) / np.maximum(sizes, LEAST_NORMAL), qacc


def check_reading(user_model: UserModel, problem: Problem, states: States) -> None:
    """ValueError, with both accelerations, where a difference of `misfits` is not below
    MODEL_TOLERANCE."""
    for (q, v), (deviations, qacc) in zip(
        states, misfits(user_model, problem, states), strict=True
    ):
        if np.max(deviations) <= MODEL_TOLERANCE:  # False for NaN
            continue
        k = int(np.argmax(np.nan_to_num(deviations, nan=np.inf)))
        system: Any = problem.system
        joint = user_model.model.joint(int(user_model.model.dof_jntid[k]))
        raise ValueError(
            f"galvi misreads this model: MuJoCo accelerates joint {joint.name or joint.id} by "
            f"{qacc[k]:.10g}, galvi by {system.acceleration(q, v)[k]:.10g}. If the model was "
            f"changed after it was compiled, call mujoco.mj_setConst(model, data) first; else "
            f"a force acts that galvi does not read: please report it."
        )


def sample_states(system: Multibody, q: Array, v: Array) -> States:
    """The start and two random states about it; for more than MANY_VELOCITIES velocities one."""
    states, draw = [(q, v)], np.random.default_rng(1)
    qpos, qvel = system.to_mujoco(q, v)
    for _ in range(1 if v.size > MANY_VELOCITIES else 2):
        random_qpos = qpos + SPREAD * draw.normal(size=qpos.size)
        states.append(system.from_mujoco(random_qpos, qvel + SPREAD * draw.normal(size=v.size)))
    return states
