"""The plane pendulum."""

from __future__ import annotations

import math

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.potentials.cosine_potential import CosinePotential


def planar_pendulum(amplitude: float = 2.0) -> Problem:
    """m = g = l = 1, released at rest at ``amplitude`` radians from the downward vertical.

    Its period is 4 K(sin(amplitude / 2)). Raises ValueError for an amplitude outside (0, pi).
    """
    angle = input_checks.real("amplitude", amplitude)
    if not 0.0 < angle < math.pi:
        raise ValueError(
            f"amplitude must be between 0 and pi radians; received {shown(amplitude)}."
        )
    return Problem(
        system=Canonical(mass=1.0, potential=CosinePotential(1.0)),
        q0=np.array([angle]),
        v0=np.zeros(1),
        name=f"planar pendulum, amplitude {angle:g}",
        parameters={"amplitude": angle},
        units="m = g = l = 1",
    )
