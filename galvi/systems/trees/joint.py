"""Links of a tree of rigid bodies, the joints between them, and the damping of these."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.groups.group import SE3, SO3, Group, Rn, check_rotation
from galvi.input_checks import shown
from galvi.kernels.compile.jit import jit
from galvi.kernels.trees import tree
from galvi.systems.rigid_body import check_moments

AXIS_ROUNDING = 4.0 * 2.0**-53  # a length that differs from 1 by at most this is taken as 1
INERTIA_ROUNDING = 1e-12  # relative to the largest entry: asymmetry, and negative moments
JOINT_TYPES = ("hinge", "slide", "ball", "free")  # numbered as in galvi.kernels.trees.tree


@dataclass(frozen=True, eq=False)
class Joint:
    """A hinge, slide, ball or free joint, in the frame of the link that it moves.

    Parameters
    ----------
    type
        "hinge": q an angle about the axis; "slide": q a length along it; "ball": q a rotation
        matrix (3, 3) that turns the link about the anchor; "free": q the origin of the link's
        frame, (3,), then its rotation matrix; only for a link on the world
    axis : array, shape (3,)
        of a hinge or a slide, of any positive length
    anchor : array, shape (3,)
        a point of the axis, or the centre of a ball joint
    zero
        the coordinate of a hinge or a slide at which the link has its place and attitude
    armature
        additional inertia of the joint's velocities, such as a motor's: kg m^2, kg for a slide; for
        a free joint both
    stiffness
        of a spring: N m/rad, N/m for a slide; for a free joint both
    rest
        coordinate at which the spring is at rest: a number, a rotation (3, 3) of a ball, a motion
        (4, 4) of a free joint; None: ``zero``, or the identity
    damping
        coefficient of the joint's velocities: N m s/rad, N s/m for a slide; for a free joint both
    name
        for tables and pictures

    Raises
    ------
    ValueError
        For another type, an axis of no length, a negative armature or damping, a zero of a ball or
        free joint, or a rest that is no coordinate of the joint.
    TypeError
        For a name that is no string.

    Examples
    --------
    >>> galvi.Joint("slide", axis=(1, 0, 0), stiffness=40.0, damping=0.5).dimension
    1
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
        if not isinstance(self.type, str) or self.type not in JOINT_TYPES:
            raise ValueError(
                f"type must be one of {', '.join(JOINT_TYPES)}; received {shown(self.type)}."
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
        if abs(length - 1.0) > AXIS_ROUNDING:  # else an axis that was normalised would change
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
                f"zero must be 0 for a {self.type} joint; received {self.zero}. Only hinges and "
                f"slides have a zero."
            )
        object.__setattr__(self, "rest", self._checked_rest())

    def _checked_rest(self) -> Any:
        if self.number <= tree.SLIDE:
            return self.zero if self.rest is None else input_checks.real("rest", self.rest)
        group = SE3() if self.type == "free" else SO3()
        pose = np.eye(group.shape[0]) if self.rest is None else self.rest
        pose = input_checks.array("rest", pose, group.shape)
        group.check("rest", pose)
        return pose

    @property
    def number(self) -> int:
        """Number of the joint's type in galvi.kernels.trees.tree."""
        return JOINT_TYPES.index(self.type)

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
        basis_vector = np.eye(3)[(int(np.argmax(np.abs(self.axis))) + 1) % 3]
        across = basis_vector - (basis_vector @ self.axis) * self.axis
        across = across / np.linalg.norm(across)
        return np.column_stack([across, np.cross(self.axis, across), self.axis])

    @property
    def rest_numbers(self) -> Array:
        """The rest in 12 numbers: the coordinate first, or the rotation by rows and the place;
        else 0."""
        numbers = np.zeros(12)
        if self.number <= tree.SLIDE:
            numbers[0] = self.rest
        else:
            numbers[:9] = self.rest[:3, :3].ravel()
            numbers[9:] = self.rest[:3, 3] if self.type == "free" else 0.0
        return numbers


@jit
def damping(q, v, t, constants, out):  # type: ignore[no-untyped-def]
    """out[1] <- out[1] - constants v."""
    for i in range(v.size):
        out[1, i] -= constants[i] * v[i]


@dataclass(frozen=True, eq=False)
class JointDamping:
    """f = -coefficients v.

    Attributes
    ----------
    coefficients : array, shape (d,)
        ValueError for a negative one
    varied
        whether the law also has the terms of coefficients that are 0
    """

    coefficients: Any
    varied: bool = False

    def __post_init__(self) -> None:
        coefficients = input_checks.array("coefficients", self.coefficients)
        if coefficients.ndim != 1 or np.any(coefficients < 0.0):
            raise ValueError(
                f"coefficients must be (d,), not negative; received {coefficients.tolist()}."
            )
        object.__setattr__(self, "coefficients", coefficients)

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        return -self.coefficients * v

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinForce.compiled`, with the coefficients for constants."""
        return damping, np.array(self.coefficients)


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid body and the joints, in their order, between it and its parent.

    Parameters
    ----------
    joints
        `Joint` values, each of which moves with those before it; without any the link is fixed to
        its parent
    mass
        not negative; kg
    centre : array, shape (3,)
        of mass, in the link's frame
    inertia
        about the centre of mass, in the link's frame: (3,) moments, a matrix (3, 3), or 0 for a
        point; a thin rod has the moment 0 about its axis. Each principal moment is at most the sum
        of the others
    parent
        index of a link before this one; None for the world
    place : array, shape (3,)
        of the link's frame in the parent's when all joints are at their zero
    attitude : array, shape (3, 3)
        rotation from the link's frame to the parent's, in the same configuration
    name
        for messages
    check
        whether an inertia that no body has is refused

    Raises
    ------
    ValueError
        For a negative mass, an inertia that is not symmetric and positive semidefinite, or that no
        body has, or a free joint beside another joint.
    TypeError
        For joints that are no `Joint` values and a check that is no bool.

    Notes
    -----
    The place and attitude of a link with a free joint are not used: its coordinates give them.

    Examples
    --------
    >>> ball = galvi.Link((galvi.Joint("ball"),), mass=1.0, centre=(0, 0, -1), inertia=0.0)
    >>> galvi.Multibody((ball,)).group.dimension
    3
    """

    joints: Any = ()
    mass: float = 0.0
    centre: Any = (0.0, 0.0, 0.0)
    inertia: Any = 0.0
    parent: int | None = None
    place: Any = (0.0, 0.0, 0.0)
    attitude: Any = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    name: str = ""
    check: bool = field(default=True, kw_only=True)

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
        input_checks.flag("check", self.check)
        mass = input_checks.real("mass", self.mass)
        if mass < 0.0:
            raise ValueError(f"mass must not be negative; received {mass}.")
        object.__setattr__(self, "mass", mass)
        for name in ("centre", "place"):
            object.__setattr__(self, name, input_checks.array(name, getattr(self, name), (3,)))
        object.__setattr__(self, "inertia", _inertia(self.inertia, self.check))
        object.__setattr__(self, "attitude", input_checks.array("attitude", self.attitude, (3, 3)))
        check_rotation("attitude", self.attitude, 3)
        if self.parent is not None:
            object.__setattr__(
                self, "parent", input_checks.whole("parent", self.parent, at_least=0)
            )


def _inertia(value: Any, check: bool) -> Array:
    """The inertia (3, 3) from a multiple of the identity, principal moments or a matrix."""
    J = input_checks.array("inertia", value)
    if J.shape not in ((), (3,), (3, 3)):
        raise ValueError(f"inertia must have shape (3,) or (3, 3), or be 0; received {J.shape}.")
    J = J if J.ndim == 2 else np.diag(np.broadcast_to(J, 3))
    size = float(np.max(np.abs(J)))
    moments = np.linalg.eigvalsh(0.5 * J + 0.5 * J.T)
    rounding = INERTIA_ROUNDING * size
    if np.max(np.abs(J - J.T)) > rounding or moments[0] < -rounding:
        raise ValueError(
            f"inertia must be symmetric and positive semidefinite; received {J.tolist()}."
        )
    if check:
        check_moments(moments, "Give three moments, each at most that sum, or check=False.")
    return read_only(0.5 * J + 0.5 * J.T)
