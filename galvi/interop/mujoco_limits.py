"""MuJoCo features that galvi does not model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.interop import mujoco_forces

Description = str | None
MAX_NAMES = 3  # largest number of objects that a message names
QUIET = (  # fields of tendons that cause no force by themselves
    *("adr", "num", "type", "treeid", "treenum", "actuatorid", "plasticadr", "group", "matid"),
    *("width", "rgba", "user", "length0", "invweight0", "lengthspring", "springyield", "range"),
    *("margin", "actfrclimited", "actfrcrange", "solref_lim", "solimp_lim", "solref_fri"),
    *("solimp_fri", "limited", "frictionloss"),
)
# Fields of tendons that galvi.interop.mujoco_forces reads or refuses by name.
UNDERSTOOD = ("stiffness", "stiffnesspoly", "damping", "dampingpoly", "armature")


class BeyondTrees(ValueError):
    """A model has features that galvi does not model.

    Attributes
    ----------
    names
        names of the features, as ``ignore`` of `galvi.from_mujoco` takes them
    """

    def __init__(self, features: dict[str, str]):
        self.names = tuple(features)
        lines = "\n".join(f"  {name}: {text}" for name, text in features.items())
        super().__init__(
            f"the model must be trees of joints with inertia, gravity, springs, dampers, motors, "
            f"servos, tendons and drag alone; received also\n{lines}\nLeave them out with "
            f"ignore={self.names!r}."
        )


def mujoco_limits(model: Any) -> dict[str, str]:
    """Name -> description of the features that change the motion and that galvi does not model."""
    descriptions = ((name, part(model)) for name, part in PARTS.items())
    return {name: text for name, text in descriptions if text}


def checked_names(ignore: Any) -> set[str]:
    """The names in PARTS that ``ignore`` lists, whatever their case, spaces and plural s.

    Raises
    ------
    TypeError
        For a value that is neither a string nor a sequence.
    ValueError
        For an unknown name.
    """
    ignored = (ignore,) if isinstance(ignore, str) else ignore
    if not input_checks.has_items(ignored):
        raise TypeError(f"ignore must be names such as ('contacts',); received {shown(ignore)}.")
    plain = {_plain(name): name for name in PARTS}
    names = list(ignored)
    for name in names:
        if not isinstance(name, str) or _plain(name) not in plain:
            raise ValueError(
                f"ignore must name some of {', '.join(PARTS)}; received {shown(name)}."
            )
    return {plain[_plain(name)] for name in names}


def _plain(name: str) -> str:
    letters = "".join(letter for letter in name.lower() if letter.isalpha())
    return letters.removesuffix("s")


def _counted(number: Any, singular: str, plural: str = "") -> Description:
    """The number with its noun, in the singular or plural; None for 0."""
    return f"{number} {singular if number == 1 else plural or singular + 's'}" if number else None


def _count_of(flags: Any, description: str) -> Description:
    """The number of set flags with a description; None for 0."""
    return f"{number} {description}" if (number := np.count_nonzero(flags)) else None


def _contacts(model: Any) -> Description:
    if mujoco_forces.disabled(model, "CONTACT", "CONSTRAINT"):
        return None
    return _counted(_pairs(model), "pair of geoms may meet", "pairs of geoms may meet")


def _pairs(model: Any) -> int:
    """Number of pairs of geoms that MuJoCo's filters let collide."""
    colliding = np.flatnonzero((model.geom_contype != 0) | (model.geom_conaffinity != 0))
    bodies = model.geom_bodyid[colliding].astype(np.int64)
    roots = model.body_weldid[bodies]
    parent_roots = model.body_weldid[model.body_parentid[roots]]
    contact_types, affinities = model.geom_contype[colliding], model.geom_conaffinity[colliding]
    filtered = not mujoco_forces.disabled(model, "FILTERPARENT")
    count = int(model.npair)
    for k in range(len(colliding)):
        later = slice(k + 1, None)
        free = roots[later] != roots[k]
        if filtered and roots[k]:
            related = (parent_roots[later] == roots[k]) | (parent_roots[k] == roots[later])
            free &= ~((roots[later] != 0) & related)
        if model.nexclude:
            low, high = np.minimum(bodies[later], bodies[k]), np.maximum(bodies[later], bodies[k])
            free &= ~np.isin((low << 16) + high, model.exclude_signature)
        compatible = (contact_types[later] & affinities[k]) | (contact_types[k] & affinities[later])
        count += int(np.count_nonzero(free & (compatible != 0)))
    return count


def _limits(model: Any) -> Description:
    if mujoco_forces.disabled(model, "LIMIT", "CONSTRAINT"):
        return None
    number = np.count_nonzero(model.jnt_limited) + np.count_nonzero(model.tendon_limited)
    return _counted(number, "limited joint" if not model.tendon_limited.any() else "limit")


def motors(model: Any, joint: int) -> list[tuple[int, float]]:
    """(index, gear) of each actuator on a hinge or a slide, on which its armature and damping act;
    [] for another joint."""
    import mujoco

    if int(model.jnt_type[joint]) not in (mujoco_forces.HINGE, mujoco_forces.SLIDE):
        return []
    kinds = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    on_joint = np.isin(model.actuator_trntype, kinds) & (model.actuator_trnid[:, 0] == joint)
    gears = model.actuator_gear[:, 0]  # a row for each output of an actuator
    return [(int(k), float(gears[model.actuator_outadr[k]])) for k in np.flatnonzero(on_joint)]


def _in_words(reasons: mujoco_forces.Reasons) -> Description:
    """The reasons as a clause, each with the names of at most MAX_NAMES objects; None for none."""
    shortened = (
        (
            why,
            ", ".join(names[:MAX_NAMES])
            + (f" and {len(names) - MAX_NAMES} more" if names[MAX_NAMES:] else ""),
        )
        for why, names in reasons.items()
    )
    return "; ".join(f"some {why} ({names})" for why, names in shortened) or None


def _actuators(model: Any) -> Description:
    reasons = mujoco_forces.unknown_actuators(model)
    resisting = (model.actuator_armature != 0.0) | (model.actuator_damping != 0.0)
    for joint in range(model.njnt):
        for k, _ in motors(model, joint):
            resisting[k] = False
    if resisting.any():
        names = [model.actuator(int(k)).name or str(k) for k in np.flatnonzero(resisting)]
        reasons["with an armature or damping, not on a hinge or slide"] = names
    return _in_words(reasons)


def tendon_forces(model: Any) -> list[str]:
    """The names of a model's fields by which tendons act, including fields unknown to galvi."""
    return [name for name in dir(model) if name[:7] == "tendon_" and name[7:] not in QUIET]


def _tendons(model: Any) -> Description:
    reasons = mujoco_forces.unknown_tendons(model)
    for name in sorted(set(tendon_forces(model)) - {f"tendon_{field}" for field in UNDERSTOOD}):
        if np.any(getattr(model, name) != 0):
            reasons.setdefault("with what galvi does not know", []).append(name)
    return _in_words(reasons)


def _equality(model: Any) -> Description:
    if mujoco_forces.disabled(model, "EQUALITY", "CONSTRAINT"):
        return None
    return _counted(np.count_nonzero(model.eq_active0), "equality constraint")


def _fluid(model: Any) -> Description:
    if (model.opt.density or model.opt.viscosity) and np.any(model.geom_fluid[:, 0]):
        return "a medium with ellipsoids in it"
    return None


def _friction(model: Any) -> Description:
    if mujoco_forces.disabled(model, "FRICTIONLOSS", "CONSTRAINT"):
        return None
    number = np.count_nonzero(model.dof_frictionloss)
    tendons = np.count_nonzero(model.tendon_frictionloss)
    counts = (
        _counted(number, "degree of freedom", "degrees of freedom"),
        _counted(tendons, "tendon"),
    )
    return " and ".join(count for count in counts if count) or None


def _gravcomp(model: Any) -> Description:
    if mujoco_forces.disabled(model, "GRAVITY"):
        return None
    limited = np.flatnonzero((model.jnt_actgravcomp != 0) & (model.jnt_actfrclimited != 0))
    if not (limited.size and np.any(model.body_gravcomp != 0.0)):
        return None
    names = [model.joint(int(k)).name or f"joint {k}" for k in limited]
    description = _in_words({"weights held by joints with limits of force": names})
    return f"{description}, which are read without their actuatorgravcomp or their actuatorfrcrange"


def _springs(model: Any) -> Description:
    if mujoco_forces.disabled(model, "SPRING"):
        return None
    unmodelled = np.any(model.jnt_stiffnesspoly != 0.0, axis=-1) & (
        model.jnt_type < mujoco_forces.SLIDE
    )
    unmodelled |= (model.jnt_stiffness != 0.0) & (model.jnt_plasticadr >= 0)
    return _count_of(unmodelled, "of a ball or free joint, or that yields")


def _dampers(model: Any) -> Description:
    if mujoco_forces.disabled(model, "DAMPER"):
        return None
    of_ball_or_free = model.jnt_type[model.dof_jntid] < mujoco_forces.SLIDE
    unmodelled = [
        *(np.any(model.dof_dampingpoly != 0.0, axis=-1) & of_ball_or_free),
        *np.any(model.actuator_dampingpoly != 0.0, axis=-1),
    ]
    return _count_of(unmodelled, "of a ball or free joint, or of an actuator")


def _sleep(model: Any) -> Description:
    import mujoco

    enabled = model.opt.enableflags & int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    return "slow trees may be put to sleep, which stops them" if enabled else None


PARTS: dict[str, Callable[[Any], Description]] = {
    "contacts": _contacts,
    "limits": _limits,
    "actuators": _actuators,
    "tendons": _tendons,
    "equality": _equality,
    "fluid": _fluid,
    "friction loss": _friction,
    "gravity compensation": _gravcomp,
    "nonlinear springs": _springs,
    "nonlinear damping": _dampers,
    "flexes": lambda model: _counted(int(model.nflex), "flexible body", "flexible bodies"),
    "plugins": lambda model: _counted(int(model.nplugin), "plugin"),
    "sleep": _sleep,
}
