"""The free box of MuJoCo's test suite."""

from __future__ import annotations

import numpy as np

from galvi.problem import Problem
from galvi.systems.rigid_body import RigidBody

SIDES = np.array([0.1, 0.2, 0.3])  # half lengths, as MuJoCo's `size` gives them
DENSITY = 1000.0


def free_box() -> Problem:
    """A box of MuJoCo's size (.1 .2 .3) and density, spun with (1, 2, 3) rad/s; no gravity.

    Inertia m / 3 times the squared half lengths of the other two sides; m = 8 * 0.006 * 1000 kg.
    """
    mass = float(8.0 * np.prod(SIDES) * DENSITY)
    inertia = mass / 3.0 * (np.sum(SIDES**2) - SIDES**2)
    return Problem(
        system=RigidBody(inertia),
        q0=np.eye(3),
        v0=np.array([1.0, 2.0, 3.0]),
        name="free box",
        parameters={"half lengths": SIDES.tolist(), "density": DENSITY},
        units="m, s, kg",
    )
