"""A robot's arm of three links on skew hinges, at rest in space or on a floating body."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.groups.product import Product
from galvi.problem import Problem
from galvi.systems.multibody import Multibody
from galvi.systems.trees.joint import Joint
from galvi.systems.trees.link import Link

AXES = ((0.0, 0.0, 1.0), (1.0, 0.3, 0.0), (0.8, -0.6, 0.2))  # of the hinges
ANGLES, RATES = (0.2, -0.4, 0.6), (1.0, -0.8, 1.5)
MOVING = (0.1, 0.0, -0.2, 0.3, -0.2, 0.4)  # the floating body


def skew_arm(damping: float = 0.0, floating: bool = False) -> Problem:
    """Three rods of 1 kg and 0.5 m on skew hinges, the first of which is vertical.

    damping   of each hinge, N m s
    floating  on a body of 5 kg that floats without weight, on R^3 x SO(3) x R^3; else on the
              ground, with gravity along -z

    Angles are 0 when the rods reach along x. Without damping the energy is conserved, and of the
    floating one the momenta. Raises ValueError for a negative damping.
    """
    value = input_checks.real("damping", damping)
    base = [Link(Joint("free"), 5.0, (0.0, 0.02, -0.1), (0.15, 0.2, 0.1), name="body")]
    links = base if floating else []
    first = len(links)
    for k, axis in enumerate(AXES):
        links.append(
            Link(
                Joint("hinge", axis=axis, armature=0.01, damping=value),
                mass=1.0,
                centre=(0.25, 0.0, 0.0),
                inertia=(0.002, 0.02, 0.02),
                parent=first + k - 1 if first + k else None,
                place=(0.5, 0.0, 0.0) if k else (0.3 * first, 0.0, 0.1 * first),
                name=f"link {k + 1}",
            )
        )
    system = Multibody(links, gravity=(0.0, 0.0, 0.0 if floating else -9.81))
    q0, v0 = np.array(ANGLES), np.array(RATES)
    if isinstance(system.group, Product):
        q0, v0 = system.group.join(np.zeros(3), np.eye(3), q0), np.array([*MOVING, *RATES])
    return Problem(
        system=system,
        q0=q0,
        v0=v0,
        name="floating arm" if floating else "skew arm",
        parameters={"damping": value, "floating": floating},
        units="kg, m, s; angles in radians",
    )
