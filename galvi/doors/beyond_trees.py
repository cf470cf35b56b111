"""What a MuJoCo model has beyond trees of rigid bodies on joints."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown

Found = str | None
SLIDE, HINGE = 2, 3  # as MuJoCo numbers joints


def beyond_trees(model: Any) -> dict[str, str]:
    """Name -> what there is, for all that changes the motion and that galvi has not."""
    found = ((name, part(model)) for name, part in PARTS.items())
    return {name: text for name, text in found if text}


def checked_names(ignore: Any) -> set[str]:
    """The names of PARTS in ``ignore``; TypeError or ValueError for anything else."""
    given = (ignore,) if isinstance(ignore, str) else ignore
    if not input_checks.has_items(given):
        raise TypeError(f"ignore must be names such as ('contacts',); received {shown(ignore)}.")
    plain = {_plain(name): name for name in PARTS}
    names = list(given)
    for name in names:
        if not isinstance(name, str) or _plain(name) not in plain:
            raise ValueError(
                f"ignore must name some of {', '.join(PARTS)}; received {shown(name)}."
            )
    return {plain[_plain(name)] for name in names}


def _plain(name: str) -> str:
    letters = "".join(letter for letter in name.lower() if letter.isalpha())
    return letters.removesuffix("s")


def _disabled(model: Any, *flags: str) -> bool:
    import mujoco

    kinds = mujoco.mjtDisableBit
    return any(model.opt.disableflags & int(getattr(kinds, f"mjDSBL_{flag}")) for flag in flags)


def _counted(number: Any, one: str, many: str = "") -> Found:
    """The number in words; None for 0."""
    return f"{number} {one if number == 1 else many or one + 's'}" if number else None


def _contacts(model: Any) -> Found:
    if _disabled(model, "CONTACT", "CONSTRAINT"):
        return None
    return _counted(_pairs(model), "pair of geoms may meet", "pairs of geoms may meet")


def _pairs(model: Any) -> int:
    """Pairs of geoms that MuJoCo's filters let collide."""
    excluded = {int(x) for x in model.exclude_signature}
    filtered = not _disabled(model, "FILTERPARENT")
    welds, parents = model.body_weldid, model.body_parentid
    groups: dict[int, list[int]] = {}
    for k, body in enumerate(model.geom_bodyid):
        if model.geom_contype[k] or model.geom_conaffinity[k]:
            groups.setdefault(int(body), []).append(k)
    count = int(model.npair)
    for one, other in combinations(sorted(groups), 2):
        roots = int(welds[one]), int(welds[other])
        if roots[0] == roots[1] or (one << 16) + other in excluded:
            continue
        if filtered and all(roots):
            above = [int(welds[parents[root]]) for root in roots]
            if above[0] == roots[1] or above[1] == roots[0]:
                continue
        a, b = groups[one], groups[other]
        first = model.geom_contype[a][:, None] & model.geom_conaffinity[b]
        second = model.geom_contype[b] & model.geom_conaffinity[a][:, None]
        count += int(np.count_nonzero(first | second))
    return count


def _limits(model: Any) -> Found:
    if _disabled(model, "LIMIT", "CONSTRAINT"):
        return None
    return _counted(np.count_nonzero(model.jnt_limited), "limited joint")


def motors(model: Any, joint: int) -> list[tuple[int, float]]:
    """The actuators on a hinge or a slide, with their gear; their armature and damping are its."""
    import mujoco

    kinds = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    found = []
    for k in range(model.nactuator):
        row = int(model.actuator_outadr[k])
        on_joint = int(model.actuator_trntype[row]) in kinds
        if on_joint and int(model.actuator_trnid[row, 0]) == joint:
            found.append((k, float(model.actuator_gear[row, 0])))
    return found if int(model.jnt_type[joint]) in (HINGE, SLIDE) else []


def _actuators(model: Any) -> Found:
    if not _disabled(model, "ACTUATION"):
        return _counted(int(model.nactuator), "actuator")
    own = (model.actuator_armature != 0.0) | (model.actuator_damping != 0.0)
    for joint in range(model.njnt):
        for k, _ in motors(model, joint):
            own[k] = False
    of = "with an armature or damping, not on a hinge or slide"
    return _counted(np.count_nonzero(own), f"actuator {of}", f"actuators {of}")


def _tendons(model: Any) -> Found:
    acting = np.zeros(model.ntendon, dtype=bool)
    for name in ("stiffness", "stiffnesspoly", "damping", "dampingpoly", "armature",
                 "frictionloss", "limited"):  # fmt: skip
        values = getattr(model, f"tendon_{name}") != 0
        acting |= values if values.ndim == 1 else np.any(values, axis=1)
    return _counted(np.count_nonzero(acting), "tendon")


def _equality(model: Any) -> Found:
    if _disabled(model, "EQUALITY", "CONSTRAINT"):
        return None
    return _counted(np.count_nonzero(model.eq_active0), "equality constraint")


def _fluid(model: Any) -> Found:
    density, viscosity = float(model.opt.density), float(model.opt.viscosity)
    if density == 0.0 and viscosity == 0.0:
        return None
    return f"a medium of density {density:g} and viscosity {viscosity:g}"


def _friction(model: Any) -> Found:
    if _disabled(model, "FRICTIONLOSS", "CONSTRAINT"):
        return None
    number = np.count_nonzero(model.dof_frictionloss)
    return _counted(number, "degree of freedom", "degrees of freedom")


def _gravcomp(model: Any) -> Found:
    if _disabled(model, "GRAVITY"):
        return None
    return _counted(np.count_nonzero(model.body_gravcomp), "compensated weight")


def _springs(model: Any) -> Found:
    if _disabled(model, "SPRING"):
        return None
    own = np.any(model.jnt_stiffnesspoly != 0.0, axis=-1) | (model.jnt_plasticadr >= 0)
    return _counted(np.count_nonzero(own), "joint")


def _dampers(model: Any) -> Found:
    if _disabled(model, "DAMPER"):
        return None
    own = [*np.any(model.dof_dampingpoly != 0.0, axis=-1),
           *np.any(model.actuator_dampingpoly != 0.0, axis=-1)]  # fmt: skip
    return _counted(np.count_nonzero(own), "damper")


PARTS: dict[str, Callable[[Any], Found]] = {
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
}
