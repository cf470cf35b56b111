"""One sand particle in the wind of a landing helicopter (M 6.2)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import checks
from galvi.kernels.jit import jit
from galvi.kernels.rotor_wind import rotor_wind
from galvi.problem import Problem
from galvi.systems.canonical import Canonical

GRAVITY = 9.80665  # m / s^2, standard gravity (CGPM 1901)
AIR = 1.225  # kg / m^3, at sea level and 15 C (ISO 2533, International Standard Atmosphere)
SAND = 2650.0  # kg / m^3, quartz (CRC Handbook of Chemistry and Physics)
DRAG_COEFFICIENT = 0.44  # of a sphere, 500 < Re < 2e5 (Bird, Stewart and Lightfoot, 6.3)
SMALLEST, LARGEST = 1e-6, 1e-2  # m
KEPT = 64  # sizes whose compiled functions stay in memory


def brownout(
    diameter: float = 100e-6,
    position: Any = (8.5, 0.0, 3.0),
    velocity: Any = (0.0, 1.0, 0.0),
    drag_coefficient: float = DRAG_COEFFICIENT,
) -> Problem:
    """Gravity, as a potential, and M's drag (14) in `galvi.kernels.rotor_wind`.

    diameter          d in m, of a sphere of quartz; sand has 10e-6 to 500e-6
    position          (3,) m from the foot of the rotor's axis, z up, above the ground
    velocity          (3,) m / s
    drag_coefficient  C_d, constant as in M (14); Stokes' law gives fine dust a larger one

    f = -(1/2) rho_air |w| w (pi d^2 / 4) C_d with w = v - wind(q, t), quadratic: only C^1 at w = 0.
    Nothing stops a particle at the ground, where no wind goes through.

    Raises ValueError for a diameter outside 1e-6 to 1e-2 m, a place below the ground, a shape that
    is not (3,) or a drag coefficient that is not positive.
    """
    d = checks.positive("diameter", diameter, "Give it in metres.")
    if not SMALLEST <= d <= LARGEST:
        raise ValueError(
            f"diameter must be from {SMALLEST:g} to {LARGEST:g} m; received {diameter!r}. "
            f"Give it in metres: 100 micrometres are 100e-6."
        )
    coefficient = checks.positive("drag_coefficient", drag_coefficient)
    place = checks.array("position", position, (3,), "Give x, y and z in metres, z up.")
    speed = checks.array("velocity", velocity, (3,), "Give x, y and z in metres a second, z up.")
    if place[2] < 0.0:
        raise ValueError(
            f"position must be above the ground, z >= 0; received z = {place[2]:g}. Raise it."
        )
    mass = SAND * math.pi * d**3 / 6.0
    system = Canonical(
        mass, *_weight(mass * GRAVITY),
        force=_drag(0.5 * AIR * math.pi * d**2 / 4.0 * coefficient), timed_force=True,
    )  # fmt: skip
    return Problem(
        system=system,
        q0=place,
        v0=speed,
        name=f"brownout, {d * 1e6:g} micrometres",
        parameters={"diameter": d, "drag_coefficient": coefficient},
        units="m, s, kg; z up from the ground, below the rotor's hub",
    )


def _flat(q: Any) -> Any:
    return np.zeros((3, 3))


FLAT: Any = jit(_flat)


@lru_cache(maxsize=KEPT)
def _weight(weight: float) -> tuple[Any, Any, Any]:
    """V = weight z, its gradient and its Hessian, of q (3,)."""

    def potential(q: Any) -> Any:
        return weight * q[2]

    def gradient(q: Any) -> Any:
        return np.array([0.0, 0.0, weight])

    return _compiled(potential, weight), _compiled(gradient, weight), FLAT


@lru_cache(maxsize=KEPT)
def _drag(factor: float) -> Any:
    """-factor |w| w, w = v - wind(q, t), of q and v (3,)."""

    def force(q: Any, v: Any, t: Any) -> Any:
        x, y, z = rotor_wind(q[0], q[1], q[2], t)
        a, b, c = v[0] - x, v[1] - y, v[2] - z
        size = factor * math.sqrt(a * a + b * b + c * c)
        return np.array([-size * a, -size * b, -size * c])

    return _compiled(force, factor)


def _compiled(function: Any, number: float) -> Any:
    """Compiled with its number in its name.

    Code that is loaded from disk keeps the names it was compiled with, and of two functions of one
    name in a process only one is ever called, whatever numbers they hold (numba 0.68).
    """
    function.__name__ += f"_{number.hex().replace('.', '_')}"
    function.__qualname__ = function.__name__
    return jit(function)
