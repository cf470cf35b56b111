"""The Kepler problem of H 2.4.2."""

from __future__ import annotations

import math

import numpy as np

from galvi import input_checks
from galvi.input_checks import shown
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.potentials.central_force import CentralForce


def kepler(eccentricity: float = 0.6) -> Problem:
    """One body around a fixed centre in the plane, GM = a = 1, from the pericentre (1 - e, 0).

    The period is 2 pi. Raises ValueError for an eccentricity outside [0, 1).
    """
    e = input_checks.real("eccentricity", eccentricity)
    if not 0.0 <= e < 1.0:
        raise ValueError(
            f"eccentricity must be in [0, 1), a bound orbit; received {shown(eccentricity)}."
        )
    return Problem(
        system=Canonical(mass=1.0, potential=CentralForce(1.0)),
        q0=np.array([1.0 - e, 0.0]),
        v0=np.array([0.0, math.sqrt((1.0 + e) / (1.0 - e))]),
        name=f"kepler e={e:g}",
        parameters={"eccentricity": e},
        units="GM = a = 1, period 2 pi",
    )
