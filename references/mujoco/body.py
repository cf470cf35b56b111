"""Converts a problem of one rigid body to MuJoCo: a joint with a body given by its inertia.

Chains of links are in `references.mujoco.chain`, trees in `references.mujoco.tree`.

The only place that knows MuJoCo's masses, frames of inertia and joints; `mujoco_states` knows its
coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import (
    Canonical,
    CosinePotential,
    FreeBody,
    Lagrangian,
    Multibody,
    Problem,
    RigidBody,
)
from galvi.arrays import Array
from references.mujoco.chain import MujocoChain, mujoco_chain
from references.mujoco.mjcf import SLACK, document, principal, text
from references.mujoco.tree import MujocoTree, is_tree
from references.newton import is_forced, is_thrown, replaces_force
from references.rigid_equations import has_known_weight
from references.textbook.chain_equations import is_chain

JOINTS = {RigidBody: "ball", FreeBody: "free", Canonical: "hinge"}
DOUBLINGS = 64


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
