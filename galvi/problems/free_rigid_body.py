"""The free rigid body of H 3.5.1."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.problem import Problem
from galvi.systems.rigid_body import RigidBody

INERTIA = (3.3, 2.5, 3.4)  # J = tr(J_d) I - J_d of H's J_d = diag(1.3, 2.1, 1.2)
VELOCITY = (2.0, -1.9, 1.0)


def free_rigid_body(
    inertia: Any = INERTIA, velocity: Any = VELOCITY, attitude: Any = None
) -> Problem:
    """A torque-free rigid body about its centre of mass.

    inertia   principal moments (3,) or a matrix (3, 3)
    velocity  (3,) angular velocity in the body's frame
    attitude  (3, 3) rotation matrix; None for the identity

    The defaults are H's. Raises ValueError as `galvi.RigidBody` and `galvi.Problem`.
    """
    return Problem(
        system=RigidBody(inertia),
        q0=np.eye(3) if attitude is None else attitude,
        v0=velocity,
        name="free rigid body",
        parameters={"inertia": np.asarray(inertia).tolist()},
        units="any: H gives none",
    )
