"""The 3D pendulum of H 3.5.2: a rigid body suspended from a fixed pivot."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.problem import Problem
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody

INERTIA = (4.8, 3.0, 3.8)  # about the pivot, from H's J_d = diag(1, 2.8, 2)
VELOCITY = (0.5, -0.5, 0.4)


def pendulum_3d(weight: float = 9.81, inverted: bool = False) -> Problem:
    """V = -weight e3 . R e3, where e3 points down (H 3.5.2).

    weight    m g times the distance 1 of the centre of mass; H gives no value
    inverted  start upside down, R = diag(-1, 1, -1), where the motion is chaotic (H fig. 3.8)

    Raises ValueError unless weight is finite and positive.
    """
    strength = input_checks.positive("weight", weight)
    return Problem(
        system=RigidBody(INERTIA, UniformGravity(1.0, (0.0, 0.0, 1.0), (0.0, 0.0, strength))),
        q0=np.diag([-1.0, 1.0, -1.0]) if inverted else np.eye(3),
        v0=np.array(VELOCITY),
        name=f"3D pendulum{', inverted' if inverted else ''}, m g = {strength:g}",
        parameters={"weight": strength, "inverted": bool(inverted)},
        units="m = 1, centre of mass at distance 1, z down",
    )
