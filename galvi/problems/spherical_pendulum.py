"""The spherical pendulum: a mass on a rod with a fixed pivot."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody

AXIAL = 0.5  # moment about the rod; it has no effect, since the rod has no spin about itself


def spherical_pendulum(angle: float = 1.0, rate: float = 0.5) -> Problem:
    """m = g = l = 1, at ``angle`` from the downward vertical, with azimuthal ``rate``.

    The rod is a symmetric rigid body that does not spin: R e3 points from the pivot to the mass.
    Raises ValueError unless 0 < angle < pi and rate is finite.
    """
    theta, turning = input_checks.real("angle", angle), input_checks.real("rate", rate)
    if not 0.0 < theta < np.pi:
        raise ValueError(f"angle must be between 0 and pi radians; received {shown(angle)}.")
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    R = Rotation.from_euler("y", theta).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    rod = R[:, 2]
    sideways = np.cross(rod, np.cross([0.0, 0.0, turning], rod))
    return Problem(
        system=RigidBody((1.0, 1.0, AXIAL), UniformGravity(1.0, (0.0, 0.0, 1.0), 1.0)),
        q0=R,
        v0=R.T @ sideways,
        name="spherical pendulum",
        parameters={"angle": theta, "rate": turning},
        units="m = g = l = 1",
    )
