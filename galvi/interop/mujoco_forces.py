"""Actuators, tendons and other forces of a MuJoCo model as `JointForces`, or why they cannot be
read.

The force of an actuator in MuJoCo is gain u + bias, with a constant control u; gain and bias are
affine in the length of the actuator and its rate.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.kernels.trees.tree import ENTRIES
from galvi.systems.finite_differences import hat
from galvi.systems.trees.joint_forces import UNLIMITED, Drive, JointForces, Pull

SLIDE, HINGE = 2, 3  # types of joints, as MuJoCo numbers them
TREE_TYPES = (3, 2, 1, 0)  # type of joint in MuJoCo -> in galvi.kernels.trees.tree
Reasons = dict[str, list[str]]  # reason -> names of the objects


def disabled(model: Any, *flags: str) -> bool:
    """Whether the model disables one of these features."""
    import mujoco

    kinds = mujoco.mjtDisableBit
    return any(model.opt.disableflags & int(getattr(kinds, f"mjDSBL_{flag}")) for flag in flags)


def rotation(quaternion: Any) -> Array:
    """The rotation (3, 3) of a quaternion of any length, as in MuJoCo the identity for 0.

    SciPy has this function too, but importing it takes as long as reading a model.
    """
    w, *along = np.asarray(quaternion, dtype=np.float64)
    skew, square = hat(np.array(along)), float(np.dot(quaternion, quaternion))
    return np.eye(3) + 2.0 / (square or 1.0) * (w * skew + skew @ skew)


def _enum_name(enum: str, number: int) -> str:
    """The name of a number in an enum of MuJoCo, without its prefix."""
    import mujoco

    return str(getattr(mujoco, enum)(int(number)).name).partition("_")[2]


def _acting(model: Any) -> Iterator[int]:
    """The numbers of the actuators that are not disabled."""
    disabled_groups = 0 if disabled(model, "ACTUATION") else int(model.opt.disableactuator)
    for k in range(0 if disabled(model, "ACTUATION") else model.nactuator):
        if not (
            0 <= model.actuator_group[k] <= 30
            and disabled_groups >> int(model.actuator_group[k]) & 1
        ):
            yield k


def _gain_and_bias(model: Any, k: int) -> tuple[Any, Any]:
    """Gain and bias of an actuator, (3,) each: the constant, then the coefficients of length and
    rate."""
    gain, bias = np.zeros(3), np.zeros(3)
    affine = _enum_name("mjtGain", model.actuator_gaintype[k]) == "AFFINE"
    gain[: 3 if affine else 1] = model.actuator_gainprm[k, : 3 if affine else 1]
    if _enum_name("mjtBias", model.actuator_biastype[k]) == "AFFINE":
        bias = model.actuator_biasprm[k, :3]
    return tuple(gain.tolist()), tuple(bias.tolist())


def _depends_on(model: Any, k: int, numbers: tuple[int, ...]) -> bool:
    """Whether the gain or bias of an actuator depends on its length (1) or rate (2)."""
    return any(law[n] != 0.0 for law in _gain_and_bias(model, k) for n in numbers)


def unknown_actuators(model: Any) -> Reasons:
    """Why actuators cannot be read -> names of these actuators."""
    reasons: Reasons = {}
    for k in _acting(model):
        if why := _why_not(model, k):
            reasons.setdefault(why, []).append(model.actuator(k).name or f"actuator {k}")
    return reasons


def _why_not(model: Any, k: int) -> str:
    """Why an actuator cannot be read; "" where it can."""
    kind = _enum_name("mjtTrn", model.actuator_trntype[k])
    of_kind = {
        "TENDON": _why_not_on_tendons,
        "SITE": _why_not_on_sites,
        "JOINT": _why_not_on_joints,
        "JOINTINPARENT": _why_not_on_joints,
    }
    elsewhere = {"SLIDERCRANK": "on cranks", "BODY": "that stick to what they touch"}
    if why := _why_not_its_law(model, k):
        return why
    if kind in of_kind:
        return of_kind[kind](model, k)
    return elsewhere.get(kind, "between sites")


def _why_not_its_law(model: Any, k: int) -> str:
    if model.actuator_actnum[k] or _enum_name("mjtDyn", model.actuator_dyntype[k]) != "NONE":
        return "with a state of their own"
    if model.actuator_plugin[k] >= 0 or model.actuator_delay[k] or model.actuator_history[k].any():
        return "of plugins, with a delay or a history"
    laws = (
        (_enum_name("mjtGain", model.actuator_gaintype[k]), ("FIXED", "AFFINE")),
        (_enum_name("mjtBias", model.actuator_biastype[k]), ("NONE", "AFFINE")),
    )
    if any(law not in understood for law, understood in laws) or model.actuator_ctrlnum[k] != 1:
        return "of another law than a motor's or a servo's"
    return ""


def _why_not_on_tendons(model: Any, k: int) -> str:
    tendon = int(model.actuator_trnid[k, 0])
    if model.tendon_actfrclimited[tendon]:
        return "on tendons with limits of force"
    kinds = _wraps(model, tendon)
    if "GEOM" in kinds:
        return "on tendons that wrap around geoms"
    return _with_limits(model) if "SITE" in kinds else ""


def _why_not_on_sites(model: Any, k: int) -> str:
    if model.actuator_trnid[k, 1] >= 0:
        return "between sites"
    return "on sites, with damping" if _depends_on(model, k, (2,)) else _with_limits(model)


def _why_not_on_joints(model: Any, k: int) -> str:
    if model.jnt_type[model.actuator_trnid[k, 0]] in (SLIDE, HINGE):
        return ""
    if _depends_on(model, k, (1,)):
        return "that are servos of ball or free joints"
    in_parent = _enum_name("mjtTrn", model.actuator_trntype[k]) == "JOINTINPARENT"
    return "in the parent frame on ball or free joints" if in_parent else ""


def _with_limits(model: Any) -> str:
    """Why actuators on paths or sites cannot be read: a joint limits forces; "" where none does."""
    return (
        "on paths or sites, of joints with limits of force" if model.jnt_actfrclimited.any() else ""
    )


def _wraps(model: Any, tendon: int) -> set[str]:
    """Types of the objects on the path of a tendon; "GEOM" for those that it wraps around."""
    first = int(model.tendon_adr[tendon])
    rows = range(first, first + int(model.tendon_num[tendon]))
    kinds = {_enum_name("mjtWrap", model.wrap_type[k]) for k in rows}
    return {"GEOM" if kind in ("SPHERE", "CYLINDER") else kind for kind in kinds}


def unknown_tendons(model: Any) -> Reasons:
    """Why forces of tendons cannot be read -> names of these tendons."""
    reasons: Reasons = {}
    for k in range(model.ntendon):
        springs = (model.tendon_stiffness[k], *model.tendon_stiffnesspoly[k])
        dampers = (model.tendon_damping[k], *model.tendon_dampingpoly[k])
        acts = (any(springs) and not disabled(model, "SPRING")) or (
            any(dampers) and not disabled(model, "DAMPER")
        )
        why = "with an armature" if model.tendon_armature[k] else ""
        if any(springs) and model.tendon_plasticadr[k] >= 0:
            why = "that yield"
        elif acts and "GEOM" in _wraps(model, k):
            why = "that wrap around geoms"
        if why:
            reasons.setdefault(why, []).append(model.tendon(k).name or str(k))
    return reasons


def forces_of(model: Any, controls: Array) -> JointForces | None:
    """The forces of a model except gravity and linear springs and damping of joints; None for none.

    Parameters
    ----------
    model
        a model whose forces can all be read
    controls : array, shape (nu,)
        constant controls of the actuators, clipped here to their ranges
    """
    entries, entry = [], 0  # index of the first entry in q of each joint
    for kind in model.jnt_type:
        entries.append(entry)
        entry += ENTRIES[TREE_TYPES[int(kind)]]
    pulls, pushes, drives = list[Pull](), list[Any](), list[Drive]()
    for k in _acting(model):
        force, thrust = _actuator(model, k, entries)
        parts: list[Any] = pushes if thrust else pulls
        parts.append(force)
        drives.append(_drive(model, k, len(parts) - 1, thrust))
    pulls += [*_tendons(model, entries), *_joints(model, entries)]
    weights, wet = [], []
    if not disabled(model, "GRAVITY"):
        weights = [(k - 1, float(x)) for k, x in enumerate(model.body_gravcomp) if k and x]
    if model.opt.density or model.opt.viscosity:
        medium = np.array([model.opt.density, model.opt.viscosity])
        wet = [(k - 1, rotation(model.body_iquat[k]), medium) for k in range(1, model.nbody)]
    if disabled(model, "SPRING") and disabled(model, "DAMPER"):  # which disables all passive forces
        weights, wet = [], []
    bounds: list[Any] = [
        (
            int(model.jnt_dofadr[k]),
            *map(float, model.jnt_actfrcrange[k]),
            model.joint(k).name or f"joint {k}",
        )
        for k in np.flatnonzero(model.jnt_actfrclimited)
        if pulls
    ]
    if not (pulls or pushes or weights or wet):
        return None
    wind = tuple(model.opt.wind.tolist())
    forces = JointForces(
        tuple(pulls), tuple(bounds), tuple(weights), tuple(pushes), tuple(wet), wind, tuple(drives)
    )
    ranges = dict.fromkeys(range(model.nu), UNLIMITED)
    ranges.update((drive.control, drive.range) for drive in drives)
    return forces.with_controls(
        np.array([min(max(float(u), ranges[k][0]), ranges[k][1]) for k, u in enumerate(controls)])
    )


def _drive(model: Any, k: int, part: int, thrust: Any) -> Drive:
    """The `Drive` of an actuator, whose pull or push has the index ``part``."""
    address = int(model.actuator_ctrladr[k])
    limits = UNLIMITED
    if model.actuator_ctrllimited[address] and not disabled(model, "CLAMPCTRL"):
        low, high = model.actuator_ctrlrange[address].tolist()
        limits = (low, high)
    gain, bias = _gain_and_bias(model, k)
    return Drive(address, part, gain, bias, limits, thrust or None)


def _actuator(model: Any, k: int, entries: list[int]) -> tuple[Any, Any]:
    """The `Pull` of an actuator and (); for one on a site its push, and ``thrust`` of `Drive`. Pull
    and push are without the force F, which `JointForces.with_controls` sets."""
    name = f"actuator {model.actuator(k).name or k}"
    gear, target = (
        model.actuator_gear[int(model.actuator_outadr[k])],
        int(model.actuator_trnid[k, 0]),
    )
    limits = UNLIMITED
    if model.actuator_forcelimited[k]:
        low, high = model.actuator_forcerange[k].tolist()
        limits = (low, high)
    kind = _enum_name("mjtTrn", model.actuator_trntype[k])
    if kind == "SITE":
        attitude, body = rotation(model.site_quat[target]), int(model.site_bodyid[target])
        thrust, link = (
            (attitude @ gear[:3], attitude @ gear[3:], limits),
            body - 1 if body else None,
        )
        return (link, model.site_pos[target].copy(), np.zeros(3), np.zeros(3)), thrust
    if kind == "TENDON":
        arms, points = _path(model, target, entries, float(gear[0]))
    else:
        dof, points = int(model.jnt_dofadr[target]), ()
        if model.jnt_type[target] in (SLIDE, HINGE):
            arms = ((dof, entries[target], float(gear[0])),)
        else:
            first = 0 if model.jnt_type[target] == 0 else 3
            arms = tuple((dof + i, -1, float(gear[i])) for i in range(6 - first))
    return Pull(name, arms, points, limits=limits, actuator=True), ()


def _path(model: Any, tendon: int, entries: list[int], scale: float) -> tuple[Any, Any]:
    """The arms of a fixed tendon and (), or () and the points of a spatial one; both give the
    length times ``scale``."""
    arms, points, divisor, begins = [], [], 1.0, True
    first = int(model.tendon_adr[tendon])
    for k in range(first, first + int(model.tendon_num[tendon])):
        kind, at = _enum_name("mjtWrap", model.wrap_type[k]), int(model.wrap_objid[k])
        if kind == "JOINT":
            ratio = scale * float(model.wrap_prm[k])
            arms.append((int(model.jnt_dofadr[at]), entries[at], ratio))
        elif kind == "PULLEY":
            divisor, begins = float(model.wrap_prm[k]), True
        else:
            body = int(model.site_bodyid[at])
            share = 0.0 if begins else scale / divisor
            points.append((body - 1 if body else None, model.site_pos[at].copy(), share))
            begins = False
    return tuple(arms), tuple(points)


def _springs(model: Any, field: str, k: int) -> tuple[float, float, float]:
    """Coefficients of a spring or damper in a field such as "tendon_stiffness"; 0 where the model
    disables it."""
    if disabled(model, "SPRING" if "stiffness" in field else "DAMPER"):
        return 0.0, 0.0, 0.0
    linear, (second, third) = getattr(model, field)[k], getattr(model, f"{field}poly")[k]
    return float(linear), float(second), float(third)


def _tendons(model: Any, entries: list[int]) -> Iterator[Pull]:
    """The pulls of springs and dampers of tendons."""
    for k in range(model.ntendon):
        spring, damper = (_springs(model, f"tendon_{x}", k) for x in ("stiffness", "damping"))
        if any(spring) or any(damper):
            shortest, longest = model.tendon_lengthspring[k].tolist()
            arms, points = _path(model, k, entries, 1.0)
            yield Pull(
                f"tendon {k}", arms, points, spring=spring, slack=(shortest, longest), damper=damper
            )


def _joints(model: Any, entries: list[int]) -> Iterator[Pull]:
    """The pulls of springs and dampers of hinges and slides, without their linear parts, which are
    in `Joint`."""
    for k in range(model.njnt):
        dof = int(model.jnt_dofadr[k])
        spring, damper = _springs(model, "jnt_stiffness", k), _springs(model, "dof_damping", dof)
        if any((*spring[1:], *damper[1:])):
            rest_position = float(model.qpos_spring[model.jnt_qposadr[k]])
            yield Pull(
                f"joint {k}",
                ((dof, entries[k], 1.0),),
                spring=(0.0, *spring[1:]),
                slack=(rest_position, rest_position),
                damper=(0.0, *damper[1:]),
            )
