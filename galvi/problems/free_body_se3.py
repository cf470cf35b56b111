"""A free rigid body that rotates and translates, on SE(3)."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.problem import Problem
from galvi.problems.free_rigid_body import INERTIA, VELOCITY
from galvi.systems.free_body import FreeBody


def free_body_se3(mass: float = 2.0, g: Any = (0.0, 0.0, 0.0)) -> Problem:
    """H's free rigid body, thrown with velocity (0.3, 0.2, -0.1) of its centre of mass.

    mass  mass of the body
    g     (3,) acceleration of gravity; the attitude does not depend on it

    Raises ValueError as `galvi.FreeBody`.
    """
    start = np.eye(4)
    return Problem(
        system=FreeBody(mass, INERTIA, g),
        q0=start,
        v0=np.array([*VELOCITY, 0.3, 0.2, -0.1]),
        name="free body on SE(3)",
        parameters={"mass": float(mass), "g": np.asarray(g, dtype=np.float64).tolist()},
        units="any",
    )
