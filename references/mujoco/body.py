"""A problem of one rigid body as MuJoCo takes it: a joint and, on it, a body given by its inertia.

Chains of links are in `references.mujoco.chain`.

The only place that knows MuJoCo's masses, frames of inertia and joints; `mujoco_states` knows its
coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from galvi import (
    Canonical,
    FreeBody,
    Lagrangian,
    PendulumWeight,
    Problem,
    RigidBody,
    UniformGravity,
)
from galvi.arrays import Array
from references.mujoco.chain import MujocoChain, mujoco_chain
from references.mujoco.mjcf import document, text
from references.newton import is_forced
from references.textbook.chain_equations import is_chain

JOINTS = {RigidBody: "ball", FreeBody: "free", Canonical: "hinge"}
DOUBLINGS = 64
SLACK = 1e-12  # relative: below that, moments are zero, and a flat body's are flat


@dataclass(frozen=True, eq=False)
class MujocoBody:
    """One body on one joint, in the world's frame at the joint's zero.

    joint    "ball", "free", or "hinge" about y
    mass     positive
    centre   (3,) of mass, from the joint, in the body's frame
    moments  (3,) about the centre of mass
    axes     (4,) quaternion, w first, that turns the body's frame into its principal axes
    gravity  (3,) acceleration in space
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
    """A rigid body, free or in uniform gravity, on SO(3) or SE(3); plane pendulums in a chain."""
    system = problem.system
    if is_forced(problem):
        return False
    if is_chain(problem):
        return True
    if isinstance(system, FreeBody):
        return True
    if isinstance(system, RigidBody):
        known = system.potential is None or isinstance(system.potential, UniformGravity)
        return known and system.gradient is None
    return (
        isinstance(system, Canonical)
        and isinstance(system.potential, PendulumWeight)
        and system.gradient is None
        and problem.q0.size == 1
    )


def mujoco_body(system: Any) -> MujocoBody | MujocoChain:
    """The body, or the chain of them, of a system whose problem is supported."""
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

    A pivot feels the inertia and mass * centre alone. Where the mass given leaves no inertia about
    the centre of mass that a body can have, as of a point on a rod, it is doubled and the lever
    halved until one is left.
    """
    for k in range(DOUBLINGS):
        m, r = mass * 2.0**k, centre / 2.0**k
        moments, axes = principal(inertia - m * (r @ r * np.eye(3) - np.outer(r, r)))
        largest, rest = np.max(moments), np.sum(moments) - np.max(moments)
        if np.min(moments) > SLACK * largest and largest <= rest * (1.0 + SLACK):
            break
    return m, r, moments, axes


def principal(inertia: Array) -> tuple[Array, Array]:
    """Moments, (3,), and the quaternion of their axes, (4,), with w first.

    MuJoCo's own ``fullinertia`` is off by some 10 roundings, and its order of the axes is its own.
    """
    moments, axes = np.diag(inertia).copy(), np.eye(3)
    if np.any(inertia != np.diag(moments)):
        moments, axes = np.linalg.eigh(inertia)
        axes[:, 0] *= np.linalg.det(axes)
    k = int(np.argmax(moments))
    rest = float(np.sum(np.delete(moments, k)))
    if moments[k] <= rest * (1.0 + SLACK):
        moments[k] = min(moments[k], rest)  # a flat body may be off by a rounding; MuJoCo's may not
    return moments, Rotation.from_matrix(axes).as_quat()[[3, 0, 1, 2]]
