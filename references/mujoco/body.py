"""Bodies, chains and trees as models of MuJoCo, and their states in MuJoCo's coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import (
    Canonical,
    CosinePotential,
    FreeBody,
    Joint,
    Lagrangian,
    Link,
    Multibody,
    PlanarChain,
    Problem,
    RigidBody,
)
from galvi.arrays import Array
from references.newton import is_forced, is_thrown, replaces_force
from references.rigid_equations import has_known_weight
from references.textbook.chain_equations import is_chain

SCALAR = ("hinge", "slide")  # types of joints with one coordinate
# Features that no single body uses, 4 % of a step, and the reset that would hide a failure.
DISABLED = (
    *("contact", "constraint", "equality", "frictionloss", "limit", "spring", "damper"),
    *("clampctrl", "actuation", "sensor", "eulerdamp", "island", "warmstart", "autoreset"),
)
# Relative rounding: smaller moments are zero, and a moment may exceed the others' sum by it.
MOMENT_ROUNDING = 1e-12
FROM_SCIPY, TO_SCIPY = [3, 0, 1, 2], [1, 2, 3, 0]  # orders of quaternions: SciPy has w last
JOINTS = {RigidBody: "ball", FreeBody: "free", Canonical: "hinge"}
DOUBLINGS = 64  # largest number of doublings of the mass of a body on a pivot


def is_tree(problem: Problem) -> bool:
    """Whether the system is a tree without forces except damping, whose springs MJCF can express:
    those of ball joints must be at rest in the reference attitude."""
    system = problem.system
    if not isinstance(system, Multibody) or system.given_force[0] is not None:
        return False
    return not any(
        joint.type == "ball" and joint.stiffness and np.any(joint.rest != np.eye(3))
        for link in system.links
        for joint in link.joints
    )


@dataclass(frozen=True, eq=False)
class MujocoTree:
    """Nested bodies; ``joint`` is the system itself, which converts states."""

    joint: Multibody

    def mjcf(self) -> str:
        """MuJoCo's XML; its numbers are read back bit for bit, but for quaternions."""
        links = self.joint.links
        inner = [""] * len(links)
        bodies = ""
        for k in range(len(links) - 1, -1, -1):
            body = _body(links[k], inner[k])
            if links[k].parent is None:
                bodies = body + bodies
            else:
                inner[links[k].parent] = body + inner[links[k].parent]
        used = ("spring", "damper", "eulerdamp")
        disabled = tuple(name for name in DISABLED if name not in used)
        return document(self.joint.gravity, bodies, disabled)


def _body(link: Link, inner: str) -> str:
    from scipy.spatial.transform import Rotation

    position, attitude = link.place, link.attitude
    if any(joint.type == "free" for joint in link.joints):
        rest_pose = link.joints[0].rest  # MuJoCo takes a free joint's from its body's pose
        position, attitude = rest_pose[:3, 3], rest_pose[:3, :3]
    inertial = ""
    if link.mass > 0.0:
        moments, axes = principal(link.inertia)
        inertial = (
            f'<inertial pos="{text(link.centre)}" quat="{text(axes)}" mass="{text([link.mass])}" '
            f'diaginertia="{text(moments)}"/>'
        )
    joints = "".join(_joint(joint) for joint in link.joints)
    quaternion = text(Rotation.from_matrix(attitude).as_quat()[[3, 0, 1, 2]])
    return f'<body pos="{text(position)}" quat="{quaternion}">{joints}{inertial}{inner}</body>'


def _joint(joint: Joint) -> str:
    attributes: dict[str, Any] = {
        "armature": joint.armature,
        "stiffness": joint.stiffness,
        "damping": joint.damping,
    }
    if joint.type != "free":
        attributes["pos"] = joint.anchor
    if joint.type in SCALAR:
        attributes |= {"axis": joint.axis, "ref": joint.zero, "springref": joint.rest}
    settings = " ".join(f'{name}="{text(np.ravel(value))}"' for name, value in attributes.items())
    return f'<joint type="{joint.type}" {settings}/>'


def document(gravity: Any, bodies: str, disabled: tuple[str, ...] = DISABLED) -> str:
    """The XML of a model with these bodies and gravity (3,); angles are in radians.

    Parameters
    ----------
    disabled
        names of the features to disable
    """
    flags = " ".join(f'{name}="disable"' for name in disabled)
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="{text(gravity)}">'
        f"<flag {flags}/></option><worldbody>{bodies}</worldbody></mujoco>"
    )


def text(numbers: Any) -> str:
    """Numbers separated by spaces, each with the digits that determine its float64."""
    return " ".join(repr(float(number)) for number in numbers)


def principal(inertia: Array) -> tuple[Array, Array]:
    """Moments, (3,), and the quaternion of their axes, (4,), with w first.

    MuJoCo's ``fullinertia`` has an error of some 10 roundings and orders the axes differently.
    """
    from scipy.spatial.transform import Rotation

    moments, axes = np.diag(inertia).copy(), np.eye(3)
    if np.any(inertia != np.diag(moments)):
        moments, axes = np.linalg.eigh(inertia)
        axes[:, 0] *= np.linalg.det(axes)
    k = int(np.argmax(moments))
    smaller_sum = float(np.sum(np.delete(moments, k)))
    if moments[k] <= smaller_sum * (1.0 + MOMENT_ROUNDING):  # MuJoCo allows no rounding here
        moments[k] = min(moments[k], smaller_sum)
    return moments, Rotation.from_matrix(axes).as_quat()[[3, 0, 1, 2]]


# Converts states between MuJoCo's coordinates and galvi's, for one body, a chain or a tree.
#
# joint   qpos                  qvel
# ball    quaternion            w
# free    x, then quaternion    velocity of x in space, then w
# hinge   angle                 rate
# chain   angles between links  their rates
#
# Quaternions have w first and take the body's frame to space; w is the angular velocity in the
# body's frame.


def to_mujoco(joint: str | Multibody, q: Array, v: Array) -> tuple[Array, Array]:
    """(qpos, qvel) of the state q, v; all may have leading axes."""
    if isinstance(joint, Multibody):
        return joint.to_mujoco(q, v)
    if joint == "hinge":
        return q, v
    if joint == "chain":
        return np.diff(q, prepend=0.0, axis=-1), np.diff(v, prepend=0.0, axis=-1)
    from scipy.spatial.transform import Rotation

    R = q[..., :3, :3]
    quaternions = Rotation.from_matrix(R).as_quat()[..., FROM_SCIPY]
    if joint == "ball":
        return quaternions, v
    drift = np.einsum("...ij,...j->...i", R, v[..., 3:])
    return (
        np.concatenate([q[..., :3, 3], quaternions], axis=-1),
        np.concatenate([drift, v[..., :3]], axis=-1),
    )


def from_mujoco(joint: str | Multibody, qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """(q, v) of rows of qpos and qvel; NaN where they are not finite."""
    if isinstance(joint, Multibody):
        return joint.from_mujoco(qpos, qvel)
    if joint == "hinge":
        return qpos, qvel
    if joint == "chain":
        return np.cumsum(qpos, axis=-1), np.cumsum(qvel, axis=-1)
    from scipy.spatial.transform import Rotation

    finite = np.all(np.isfinite(qpos), axis=-1)
    R = np.full((len(qpos), 3, 3), np.nan)
    R[finite] = Rotation.from_quat(qpos[finite, -4:][:, TO_SCIPY]).as_matrix()
    if joint == "ball":
        return R, qvel
    q = np.zeros((len(qpos), 4, 4))
    q[:, :3, :3], q[:, :3, 3], q[:, 3, 3] = R, qpos[:, :3], 1.0
    drift = np.einsum("nji,nj->ni", R, qvel[:, :3])
    return q, np.concatenate([qvel[:, 3:], drift], axis=-1)


# A problem of one rigid body becomes a joint with a body given by its inertia.


@dataclass(frozen=True, eq=False)
class MujocoBody:
    """One body on one joint, in the world's frame at the joint's zero.

    Attributes
    ----------
    joint
        "ball", "free", or "hinge" about y
    mass
        positive
    centre : array, shape (3,)
        of mass, from the joint, in the body's frame
    moments : array, shape (3,)
        about the centre of mass
    axes : array, shape (4,)
        quaternion, w first, that turns the body's frame into its principal axes
    gravity : array, shape (3,)
        acceleration in space
    """

    joint: str
    mass: float
    centre: Any
    moments: Any
    axes: Any
    gravity: Any

    def mjcf(self) -> str:
        """MuJoCo's XML; its numbers are read back bit for bit."""
        return document(
            self.gravity,
            f'<body><joint type="{self.joint}" axis="0 1 0"/><inertial '
            f'pos="{text(self.centre)}" quat="{text(self.axes)}" mass="{text([self.mass])}" '
            f'diaginertia="{text(self.moments)}"/></body>',
        )


def supports(problem: Problem) -> bool:
    """A rigid body, free or in uniform gravity, on SO(3) or SE(3); plane pendulums in a chain; a
    tree, its damping included."""
    system = problem.system
    if is_tree(problem):
        return True
    if is_forced(problem):
        return False
    if is_chain(problem):
        return True
    if isinstance(system, FreeBody):
        return is_thrown(problem)
    if isinstance(system, RigidBody):
        return system.potential is None or has_known_weight(problem)
    return (
        isinstance(system, Canonical)
        and isinstance(system.potential, CosinePotential)
        and not replaces_force(problem)
        and problem.q0.size == 1
    )


def mujoco_body(system: Any) -> MujocoBody | MujocoChain | MujocoTree:
    """The body, the chain or the tree of bodies of a supported problem's system."""
    if isinstance(system, Multibody):
        return MujocoTree(system)
    if isinstance(system, Lagrangian):
        return mujoco_chain(system.function)
    joint = JOINTS[type(system)]
    if joint == "free":
        about_centre = principal(system.inertia)
        return MujocoBody(joint, system.mass, np.zeros(3), *about_centre, system.g)
    if joint == "hinge":  # mass times lever is 1, so that gravity is the weight
        inertia = float(np.ravel(system.mass)[0]) * np.eye(3)
        gravity = np.array([0.0, 0.0, -system.potential.weight])
        return MujocoBody(joint, *on_a_pivot(1.0, np.array([0.0, 0.0, -1.0]), inertia), gravity)
    weight = system.potential
    if weight is None:
        return MujocoBody(joint, 1.0, np.zeros(3), *principal(system.inertia), np.zeros(3))
    return MujocoBody(joint, *on_a_pivot(weight.mass, weight.centre, system.inertia), weight.g)


def on_a_pivot(mass: float, centre: Array, inertia: Array) -> tuple[float, Array, Array, Array]:
    """mass, centre, moments and axes about the centre of mass, from the inertia about the pivot.

    The motion depends on the inertia and on mass * centre alone. Where the mass leaves no possible
    inertia about the centre of mass, as of a point on a rod, it is doubled and the lever halved
    until it does.
    """
    for k in range(DOUBLINGS):
        m, r = mass * 2.0**k, centre / 2.0**k
        moments, axes = principal(inertia - m * (r @ r * np.eye(3) - np.outer(r, r)))
        largest, smaller_sum = np.max(moments), np.sum(moments) - np.max(moments)
        if np.min(moments) > MOMENT_ROUNDING * largest and largest <= smaller_sum * (
            1.0 + MOMENT_ROUNDING
        ):
            break
    return m, r, moments, axes


@dataclass(frozen=True, eq=False)
class MujocoChain:
    """Links that hang from each other, in the world's frame when all hang straight down.

    Attributes
    ----------
    lengths : array, shape (n,)
    masses : array, shape (n,)
    levers : array, shape (n,)
        of the centres of mass, from each link's upper hinge
    moments : array, shape (n,)
        about the centres of mass, for rotation in the plane
    gravity
        downward acceleration

    Notes
    -----
    A link is a body whose three moments are the same, so that no moment is as small as a thin rod's
    about itself. MuJoCo's angles are those between links.
    """

    lengths: Array
    masses: Array
    levers: Array
    moments: Array
    gravity: float
    joint: str = "chain"

    def mjcf(self) -> str:
        """MuJoCo's XML; its numbers are read back bit for bit."""
        bodies = ""
        offsets = np.append(0.0, self.lengths[:-1])
        links = zip(offsets, self.masses, self.levers, self.moments, strict=True)
        for offset, mass, lever, moment in reversed(list(links)):
            bodies = (
                f'<body pos="{text([0.0, 0.0, -offset])}"><joint type="hinge" axis="0 -1 0"/>'
                f'<inertial pos="{text([0.0, 0.0, -lever])}" mass="{text([mass])}" '
                f'diaginertia="{text([moment] * 3)}"/>{bodies}</body>'
            )
        return document([0.0, 0.0, -self.gravity], bodies)


def mujoco_chain(chain: PlanarChain) -> MujocoChain:
    """Bodies with the same motion that MuJoCo accepts.

    It takes no points, which have no moment of inertia. A point between two links belongs to
    either, so each link carries half of the point at its hinge and half of the one at its end, or
    all of the last; at the fixed hinge any mass does.
    """
    m, l = chain.masses, chain.lengths
    if chain.rods:
        return MujocoChain(l, m, 0.5 * l, m * l * l / 12.0, chain.gravity)
    low = np.append(0.5 * m[:-1], m[-1])
    high = np.append(0.5 * m[0], 0.5 * m[:-1])
    total = low + high
    return MujocoChain(l, total, low * l / total, high * low * l * l / total, chain.gravity)
