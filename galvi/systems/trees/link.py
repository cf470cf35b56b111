"""Rigid bodies of a tree, with the joints that move them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.groups.matrices import check_rotation
from galvi.input_checks import shown
from galvi.systems.trees.joint import Joint

SLACK = 1e-12


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body and the joints, in their order, between it and its parent.

    joints    none: it is fixed to its parent; each joint moves with those before it
    mass      not negative; kg
    centre    (3,) of mass, in the link's frame
    inertia   about the centre of mass, in the link's frame: (3,) moments, (3, 3), or 0; a thin rod
              has none about itself
    parent    number of another link, before this one; None for the world
    place     (3,) of the link's frame in the parent's when all joints are at their zero
    attitude  (3, 3) from the link's frame to the parent's then
    name      for messages

    place and attitude of a link with a free joint are its coordinates, and not used. Raises
    ValueError for a negative mass, an inertia that is not symmetric and positive semidefinite, or
    a free joint among others.
    """

    joints: Any = ()
    mass: float = 0.0
    centre: Any = (0.0, 0.0, 0.0)
    inertia: Any = 0.0
    parent: int | None = None
    place: Any = (0.0, 0.0, 0.0)
    attitude: Any = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    name: str = ""

    def __post_init__(self) -> None:
        joints = input_checks.several(self.joints)
        if not all(isinstance(joint, Joint) for joint in joints):
            raise TypeError(f"joints must be galvi.Joint values; received {shown(self.joints)}.")
        if len(joints) > 1 and any(joint.type == "free" for joint in joints):
            raise ValueError(
                f"a free joint must be the only one of its link; received "
                f"{[joint.type for joint in joints]}."
            )
        object.__setattr__(self, "joints", joints)
        mass = input_checks.real("mass", self.mass)
        if mass < 0.0:
            raise ValueError(f"mass must not be negative; received {mass}.")
        object.__setattr__(self, "mass", mass)
        for name in ("centre", "place"):
            object.__setattr__(self, name, input_checks.array(name, getattr(self, name), (3,)))
        object.__setattr__(self, "inertia", _inertia(self.inertia))
        object.__setattr__(self, "attitude", input_checks.array("attitude", self.attitude, (3, 3)))
        check_rotation("attitude", self.attitude, 3)
        if self.parent is not None:
            object.__setattr__(
                self, "parent", input_checks.whole("parent", self.parent, at_least=0)
            )


def _inertia(value: Any) -> Array:
    """(3, 3) from 0, moments or a matrix."""
    J = input_checks.array("inertia", value)
    if J.shape not in ((), (3,), (3, 3)):
        raise ValueError(f"inertia must have shape (3,) or (3, 3), or be 0; received {J.shape}.")
    J = J if J.ndim == 2 else np.diag(np.broadcast_to(J, 3))
    size = float(np.max(np.abs(J)))
    moments = np.linalg.eigvalsh(0.5 * J + 0.5 * J.T)
    if np.max(np.abs(J - J.T)) > SLACK * size or moments[0] < -SLACK * size:
        raise ValueError(
            f"inertia must be symmetric and positive semidefinite; received {J.tolist()}."
        )
    return read_only(0.5 * J + 0.5 * J.T)
