"""The Kepler problem in polar coordinates."""

from __future__ import annotations

from functools import cache

import numpy as np

from galvi.problem import Problem
from galvi.problems.kepler import kepler
from galvi.symbolic.from_sympy import sympy_module
from galvi.systems.lagrangian import Lagrangian


def kepler_polar(eccentricity: float = 0.3) -> Problem:
    """The motion of `kepler` in the coordinates r and phi, the angle from the pericentre; needs
    SymPy.

    L = (r'^2 + r^2 phi'^2) / 2 + mu / r, mu = 1

    Raises ImportError without SymPy, ValueError for an eccentricity outside [0, 1).
    """
    plane = kepler(eccentricity)
    r, speed = float(plane.q0[0]), float(plane.v0[1])
    return Problem(
        system=_system(),
        q0=np.array([r, 0.0]),
        v0=np.array([0.0, speed / r]),
        name=f"{plane.name} in polar coordinates",
        parameters=plane.parameters,
        units=plane.units,
    )


@cache
def _system() -> Lagrangian:
    sympy = sympy_module()
    mu, r, phi, speed, turning = sympy.symbols("mu r phi r' phi'", real=True)
    kinetic = (speed**2 + r**2 * turning**2) / 2
    return Lagrangian.from_sympy(kinetic + mu / r, [r, phi], [speed, turning], parameters={mu: 1.0})
