"""Joints between rigid bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.groups.group import Group
from galvi.groups.rn import Rn
from galvi.groups.se3 import SE3
from galvi.groups.so3 import SO3
from galvi.input_checks import shown
from galvi.kernels.lanes.trees import tree

UNIT = 4.0 * 2.0**-53  # the rounding of a length of 1
KINDS = ("hinge", "slide", "ball", "free")  # numbered as in galvi.kernels.lanes.trees.tree


@dataclass(frozen=True, eq=False)
class Joint:
    """A hinge, slide, ball or free joint, in the frame of the link that it moves.

    type       "hinge": q an angle about the axis; "slide": q a length along it; "ball": q a
               rotation matrix (3, 3) that turns the link about the anchor; "free": q the origin of
               the link's frame, (3,), then its rotation matrix; only for a link on the world
    axis       (3,) of a hinge or a slide, of any length but zero
    anchor     (3,) a point of the axis, or the centre of a ball joint
    zero       the coordinate of a hinge or a slide at which the link is at its place
    armature   inertia that its velocities have besides, such as a motor's: kg m^2, kg for a slide
    stiffness  of a spring: N m/rad, N/m for a slide; of a free joint both
    rest       where the spring is at rest: a coordinate; (3, 3), or of a free joint a motion (4, 4)
    damping    of its velocities: N m s/rad, N s/m for a slide; of a free joint both
    name       for tables and pictures

    Raises ValueError for another type, an axis of no length, a negative armature or damping, or a
    rest that is no coordinate of the joint, and TypeError for a name that is no string.
    """

    type: str
    axis: Any = (0.0, 0.0, 1.0)
    anchor: Any = (0.0, 0.0, 0.0)
    zero: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0
    rest: Any = None
    damping: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.type, str) or self.type not in KINDS:
            raise ValueError(
                f"type must be one of {', '.join(KINDS)}; received {shown(self.type)}."
            )
        if not isinstance(self.name, str):
            raise TypeError(f"name must be a string; received {shown(self.name)}.")
        axis = input_checks.array("axis", self.axis, (3,))
        with np.errstate(over="ignore"):
            length = float(np.linalg.norm(axis))
        if not 0.0 < length < math.inf:
            raise ValueError(
                f"axis must have a length above 0 that does not overflow; received {axis.tolist()}."
            )
        if abs(length - 1.0) > UNIT:  # a stored axis stays the same
            axis = axis / length
        object.__setattr__(self, "axis", read_only(np.array(axis)))
        object.__setattr__(self, "anchor", input_checks.array("anchor", self.anchor, (3,)))
        for name in ("zero", "armature", "stiffness", "damping"):
            object.__setattr__(self, name, input_checks.real(name, getattr(self, name)))
        for name in ("armature", "damping"):
            if getattr(self, name) < 0.0:
                raise ValueError(f"{name} must not be negative; received {getattr(self, name)}.")
        if self.number > tree.SLIDE and self.zero != 0.0:
            raise ValueError(
                f"zero is of a hinge or a slide; received {self.zero} for {self.type}."
            )
        object.__setattr__(self, "rest", self._checked_rest())

    def _checked_rest(self) -> Any:
        if self.number <= tree.SLIDE:
            return self.zero if self.rest is None else input_checks.real("rest", self.rest)
        group = SE3() if self.type == "free" else SO3()
        rest = np.eye(group.shape[0]) if self.rest is None else self.rest
        found = input_checks.array("rest", rest, group.shape)
        group.check("rest", found)
        return found

    @property
    def number(self) -> int:
        """Its kind in galvi.kernels.lanes.trees.tree."""
        return KINDS.index(self.type)

    @property
    def groups(self) -> tuple[Group, ...]:
        """The groups of its coordinates."""
        return ((Rn(1),), (Rn(1),), (SO3(),), (Rn(3), SO3()))[self.number]

    @property
    def dimension(self) -> int:
        """Number of its velocities."""
        return tree.DOFS[self.number]

    @property
    def frame(self) -> Array:
        """Rotation (3, 3) from the joint's frame, whose z axis is its axis, to the link's."""
        if self.number > tree.SLIDE:
            return np.eye(3)
        near = np.eye(3)[(int(np.argmax(np.abs(self.axis))) + 1) % 3]
        across = near - (near @ self.axis) * self.axis
        across = across / np.linalg.norm(across)
        return np.column_stack([across, np.cross(self.axis, across), self.axis])

    @property
    def rest_numbers(self) -> Array:
        """(12,) the rest's coordinate, or its rotation by rows and its place."""
        found = np.zeros(12)
        if self.number <= tree.SLIDE:
            found[0] = self.rest
        else:
            found[:9] = self.rest[:3, :3].ravel()
            found[9:] = self.rest[:3, 3] if self.type == "free" else 0.0
        return found
