"""The heavy symmetric top of Lagrange."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody


def heavy_top(spin: float = 8.0, tilt: float = 0.5) -> Problem:
    """A top on a fixed tip, released at angle ``tilt`` from upright, rotating at rate ``spin``.

    The spin is about the axis of symmetry. Moments of inertia (1.5, 1.5, 0.5) about the tip,
    m g l = 2, gravity along -z. Energy, angular momentum about the vertical and, by symmetry, about
    the axis are conserved. An upright top is stable (sleeping) when (0.5 spin)^2 > 4 * 1.5 m g l =
    12. Raises ValueError unless 0 < tilt < pi.
    """
    rate, angle = input_checks.real("spin", spin), input_checks.real("tilt", tilt)
    if not 0.0 < angle < np.pi:
        raise ValueError(f"tilt must be between 0 and pi radians; received {shown(tilt)}.")
    from scipy.spatial.transform import Rotation  # a fifth of galvi's import

    return Problem(
        system=RigidBody((1.5, 1.5, 0.5), UniformGravity(1.0, (0.0, 0.0, 1.0), 2.0)),
        q0=Rotation.from_euler("x", angle).as_matrix(),
        v0=np.array([0.0, 0.0, rate]),
        name="heavy top",
        parameters={"spin": rate, "tilt": angle},
        units="m = 1, l = 1, g = 2",
    )
