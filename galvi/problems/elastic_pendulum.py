"""The elastic pendulum: a mass on a spring, in polar coordinates."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from galvi import input_checks
from galvi.problem import Problem
from galvi.symbolic.from_sympy import sympy_module
from galvi.systems.lagrangian import Lagrangian


def elastic_pendulum(
    mass: float = 1.0,
    stiffness: float = 40.0,
    length: float = 1.0,
    gravity: float = 9.81,
    extended: float = 1.3,
    angle: float = 1.5,
) -> Problem:
    """A mass on a spring of this length at rest, hung from a point, in a plane; needs SymPy.

    L = m (r'^2 + r^2 theta'^2) / 2 - k (r - l)^2 / 2 + m g r cos theta

    extended, angle  r and theta at the start, at rest; theta in radians from the downward vertical

    Raises ImportError without SymPy, ValueError for a mass,
    stiffness, length or start r that is not positive.
    """
    numbers = [
        input_checks.positive(name, value)
        for name, value in (("mass", mass), ("stiffness", stiffness), ("length", length))
    ]
    numbers.append(input_checks.real("gravity", gravity))
    start = [input_checks.positive("extended", extended), input_checks.real("angle", angle)]
    return Problem(
        system=_system(*numbers),
        q0=np.array(start),
        v0=np.zeros(2),
        name="elastic pendulum",
        parameters=dict(zip(("mass", "stiffness", "length", "gravity"), numbers, strict=True)),
        units="those of mass, stiffness, length and gravity; angles in radians",
    )


@lru_cache(maxsize=16)
def _system(mass: float, stiffness: float, length: float, gravity: float) -> Lagrangian:
    sympy = sympy_module()
    m, k, l, g, r, theta, speed, turning = sympy.symbols("m k l g r theta r' theta'", real=True)
    kinetic = m * (speed**2 + r**2 * turning**2) / 2
    return Lagrangian.from_sympy(
        kinetic - k * (r - l) ** 2 / 2 + m * g * r * sympy.cos(theta),
        [r, theta],
        [speed, turning],
        parameters={m: mass, k: stiffness, l: length, g: gravity},
    )
