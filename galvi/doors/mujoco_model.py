"""A user's MuJoCo model: where it starts, what of it is switched off, what of it is known.

MuJoCo's names begin with the object that they are of, as in body_mass.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.doors.beyond_trees import motors, tendon_forces
from galvi.problem import Problem
from galvi.systems.forces.external_force import force_at
from galvi.systems.multibody import Multibody

AGREED = 1e-8  # of the forces on a velocity; 2e-13 in public models, 1e-9 with rounded quaternions
FLOOR = 1e-4  # share of the largest force that counts as one
SPREAD, MANY = 0.5, 200  # of random states; velocities from which one of them is compared, not two
States = Sequence[tuple[Array, Array]]
TINY = float(np.finfo(float).tiny)
TURNING = {"hinge": [1.0], "slide": [0.0], "ball": [1.0] * 3, "free": [0.0] * 3 + [1.0] * 3}

# Objects, all of whose fields change no motion of joints, or do it through parts that are named in
# `galvi.doors.beyond_trees`: pictures, names, sizes and addresses, sensors, keyframes; contacts,
# tendons, actuators, constraints, flexible bodies and plugins.
OBJECTS = (
    *("cam", "light", "mat", "mesh", "tex", "text", "skin", "skinbone", "hfield", "site", "sensor"),
    *("bvh", "oct", "numeric", "tuple", "key", "name", "names", "B", "D", "M", "mapM2M", "mapM2D"),
    *("mapD2M", "efm0", "efmC", "geom", "pair", "exclude", "tendon", "ten", "wrap", "actuator"),
    *("eq", "flex", "flexedge", "plugin", "flg"),
)
READ = {
    *("body_parentid", "body_jntnum", "body_jntadr", "body_pos", "body_quat", "body_ipos"),
    *("body_iquat", "body_mass", "body_inertia", "body_mocapid", "body_gravcomp", "body_plugin"),
    *("jnt_type", "jnt_qposadr", "jnt_dofadr", "jnt_bodyid", "jnt_pos", "jnt_axis", "qpos0"),
    *("jnt_stiffness", "jnt_stiffnesspoly", "jnt_plasticadr", "jnt_limited", "qpos_spring"),
    *("dof_armature", "dof_damping", "dof_dampingpoly", "dof_frictionloss", "tree_sleep_policy"),
}
DERIVED = {  # from those, or of contacts, limits, friction loss and actuators
    *("body_rootid", "body_weldid", "body_dofnum", "body_dofadr", "body_treeid", "body_geomnum"),
    *("body_geomadr", "body_simple", "body_sameframe", "body_subtreemass", "body_invweight0"),
    *("body_margin", "body_contype", "body_conaffinity", "body_bvhadr", "body_bvhnum", "body_user"),
    *("jnt_group", "jnt_solref", "jnt_solimp", "jnt_range", "jnt_margin", "jnt_user"),
    *("jnt_actfrclimited", "jnt_actgravcomp", "jnt_actfrcrange", "jnt_springyield"),
    *("jnt_actuatorid", "dof_bodyid", "dof_jntid", "dof_parentid", "dof_treeid", "dof_Madr"),
    *("dof_simplenum", "dof_solref", "dof_solimp", "dof_invweight0", "dof_M0", "dof_length"),
    *("tree_bodyadr", "tree_bodynum", "tree_dofadr", "tree_dofnum", "signature"),
}
OPTIONS = {  # those that are read, of integrators, or of contacts, constraints, fluids and sensors
    *("timestep", "gravity", "integrator", "disableflags", "enableflags", "density", "viscosity"),
    *("wind", "magnetic", "impratio", "tolerance", "ls_tolerance", "noslip_tolerance", "cone"),
    *("ccd_tolerance", "o_margin", "o_solref", "o_solimp", "o_friction", "jacobian", "solver"),
    *("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations", "sdf_initpoints"),
    *("sdf_iterations", "sleep_tolerance", "disableactuator"),
}
FLAGS = {
    "disableflags": (
        *("CONSTRAINT", "EQUALITY", "FRICTIONLOSS", "LIMIT", "CONTACT", "SPRING", "DAMPER"),
        *("GRAVITY", "CLAMPCTRL", "WARMSTART", "FILTERPARENT", "ACTUATION", "REFSAFE", "SENSOR"),
        *("MIDPHASE", "EULERDAMP", "AUTORESET", "NATIVECCD", "ISLAND", "MULTICCD"),
    ),
    "enableflags": (
        *("OVERRIDE", "ENERGY", "FWDINV", "INVDISCRETE", "SLEEP", "DIAGEXACT", "IPC"),
        "SPECULATIVE",
    ),
}
CALLBACKS = ("passive", "control", "act_dyn", "act_gain", "act_bias")
# How a part is switched off: by a flag, or by fields that get a value.
SWITCHES: dict[str, tuple[tuple[str, ...], dict[str, float]]] = {
    "contacts": (("CONTACT",), {}),
    "limits": (("LIMIT",), {}),
    "actuators": (("ACTUATION",), {}),
    "tendons": ((), {}),  # all of `tendon_forces`
    "equality": (("EQUALITY",), {}),
    "fluid": ((), {"opt.density": 0.0, "opt.viscosity": 0.0}),
    "friction loss": (("FRICTIONLOSS",), {}),
    "gravity compensation": ((), {"body_gravcomp": 0.0}),
    "nonlinear springs": ((), {"jnt_stiffnesspoly": 0.0, "jnt_plasticadr": -1.0}),
    "nonlinear damping": ((), {"dof_dampingpoly": 0.0, "actuator_dampingpoly": 0.0}),
    "flexes": ((), dict.fromkeys(
        ("flex_stiffness", "flex_bending", "flex_damping", "flex_edgestiffness",
         "flex_edgedamping", "flex_contype", "flex_conaffinity", "flex_selfcollide",
         "flex_passive"), 0.0)),
    "plugins": ((), {}),  # no way is known: those that act are refused by their accelerations
    "sleep": ((), {}),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Own:
    """A user's own model as its engine runs it.

    model        a copy of the `MjModel`, in which nothing but what is left out was changed
    differences  what was left out: name -> how, in words
    key          number of the keyframe at which it starts; None: the reference configuration
    qpos, qvel   (nq,) and (nv,) of the start where they are given; else None
    """

    model: Any
    differences: dict[str, str]
    key: int | None = None
    qpos: Any = None
    qvel: Any = None

    def data(self) -> Any:
        """A new `MjData` at the start, with mocap bodies where the keyframe has them."""
        import mujoco

        data = mujoco.MjData(self.model)
        if self.key is not None:
            mujoco.mj_resetDataKeyframe(self.model, data, self.key)
        for name in ("qpos", "qvel"):
            if getattr(self, name) is not None:
                getattr(data, name)[:] = getattr(self, name)
        return data


def without(model: Any, parts: Iterable[str]) -> tuple[Any, dict[str, str]]:
    """A copy of the model with these parts switched off, and how it was done."""
    import mujoco

    made, how = copy.copy(model), {}
    for part in sorted(parts):
        flags, fields = SWITCHES[part]
        if part == "tendons":
            fields = dict.fromkeys(tendon_forces(made), 0.0)
        for flag in flags:
            made.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
        if part == "sleep":
            made.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        for name, value in fields.items():
            if name.startswith("opt."):
                setattr(made.opt, name[4:], value)
            else:
                getattr(made, name)[:] = value
        words = [f"{name} = {value:g}" for name, value in fields.items()]
        words += [f"the flag {flag.lower()} disabled" for flag in (*flags, *_enabled(part))]
        how[part] = ", ".join(words) or "left as they are, since they accelerate nothing"
    if "actuators" in how and _without_motors(made):  # joints feel them all the same
        how["actuators"] += ", armature and damping = 0 of those not on a hinge or slide"
    return made, how


def _enabled(part: str) -> tuple[str, ...]:
    return ("SLEEP",) if part == "sleep" else ()


def _without_motors(model: Any) -> bool:
    """Without armature and damping of actuators not on a hinge or slide; whether any had some."""
    on_joints = {k for joint in range(model.njnt) for k, _ in motors(model, joint)}
    others = sorted(set(range(model.nactuator)) - on_joints)
    found = bool(np.any(model.actuator_armature[others]) or np.any(model.actuator_damping[others]))
    model.actuator_armature[others] = model.actuator_damping[others] = 0.0
    return found


def unknown(model: Any) -> Iterator[str]:
    """What is set in the model and neither understood nor known to change no motion."""
    import mujoco

    for name in dir(model):
        value = getattr(model, name)
        is_size = isinstance(value, int) and name.startswith("n")
        if name.startswith("_") or is_size or name in READ | DERIVED:
            continue
        if not isinstance(value, np.ndarray | bool | int | float):
            continue
        if name.partition("_")[0] not in OBJECTS and np.any((value != 0) & (value != -1)):
            yield name
    for name in dir(model.opt):
        value = getattr(model.opt, name)
        known = name.startswith("_") or callable(value) or name in OPTIONS
        if not known and np.any(np.asarray(value) != 0):
            yield f"option {name}"
    for name, kinds in FLAGS.items():
        prefix = "mjDSBL" if name == "disableflags" else "mjENBL"
        enum = mujoco.mjtDisableBit if name == "disableflags" else mujoco.mjtEnableBit
        bits = sum(int(getattr(enum, f"{prefix}_{kind}", 0)) for kind in kinds)
        if getattr(model.opt, name) & ~bits:
            yield f"bits {getattr(model.opt, name) & ~bits:#x} of {name}"
    for name in CALLBACKS:
        if getattr(mujoco, f"get_mjcb_{name}")() is not None:
            yield f"the callback mjcb_{name}"


def misfits(own: Own, problem: Problem, states: States) -> Iterator[tuple[Array, Array]]:
    """How far the accelerations that MuJoCo computes of the user's own model are from those of the
    problem, of a `Multibody`, at each of the states (q, v): the differences (d,), times the mass
    and relative to the forces, and MuJoCo's accelerations (d,)."""
    import mujoco

    system: Any = problem.system
    data, joints, model = own.data(), system.tree.joints, copy.copy(own.model)
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_RK4)  # discrete has others in qacc
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_IPC)  # which is of discrete alone
    turning = np.concatenate([TURNING[joint.type] for joint in joints])
    springs = np.concatenate([np.full(joint.dimension, joint.stiffness) for joint in joints])
    weight = float(np.linalg.norm(system.gravity)) * sum(x.mass for x in system.links) ** 0.5
    for q, v in states:
        data.qpos[:], data.qvel[:] = system.to_mujoco(q, v)
        mujoco.mj_forward(model, data)
        theirs, mass = np.array(data.qacc), system.tree.mass(q)
        forces = system.tree.forces(q, v) + force_at(system, q, v, problem.t0)
        sizes = np.abs(mass) @ np.abs(theirs) + np.abs(forces)
        sizes += np.abs(data.qfrc_spring) + np.abs(data.qfrc_damper)
        # Where all this cancels: what weights, centrifugal forces and springs may be at most.
        roots = np.sqrt(np.maximum(np.diag(mass), TINY))
        most = weight + turning @ np.abs(v) * abs(v @ mass @ v) ** 0.5 + np.max(sizes / roots)
        sizes += FLOOR * (roots * most + springs)
        yield np.abs(mass @ theirs - forces) / np.maximum(sizes, TINY), theirs


def check_reading(own: Own, problem: Problem, states: States) -> None:
    """ValueError, with both accelerations, where one of `misfits` is above AGREED."""
    for (q, v), (off, theirs) in zip(states, misfits(own, problem, states), strict=True):
        if np.max(off) <= AGREED:  # not where it is no number
            continue
        k = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
        system: Any = problem.system
        joint = own.model.joint(int(own.model.dof_jntid[k]))
        raise ValueError(
            f"galvi misreads this model: MuJoCo accelerates joint {joint.name or joint.id} by "
            f"{theirs[k]:.10g}, galvi by {system.acceleration(q, v)[k]:.10g}. If the model was "
            f"changed after it was compiled, call mujoco.mj_setConst(model, data) first; else "
            f"something acts that was not seen: please report it."
        )


def some_states(system: Multibody, q: Array, v: Array) -> States:
    """The start and two random states about it, one of a large tree."""
    found, draw = [(q, v)], np.random.default_rng(1)
    qpos, qvel = system.to_mujoco(q, v)
    for _ in range(1 if v.size > MANY else 2):
        moved = qpos + SPREAD * draw.normal(size=qpos.size)
        found.append(system.from_mujoco(moved, qvel + SPREAD * draw.normal(size=v.size)))
    return found
