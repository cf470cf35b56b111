"""One sand particle in the wind of a landing helicopter (M 6.2)."""

from __future__ import annotations

import math
from typing import Any

from galvi import input_checks
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.forces.drag import RotorDrag, SchillerNaumann
from galvi.systems.potentials.potentials import UniformField

GRAVITY = 9.80665  # m / s^2, standard gravity (CGPM 1901)
AIR_DENSITY = 1.225  # kg / m^3, at sea level and 15 C (ISO 2533)
SAND_DENSITY = 2650.0  # kg / m^3, quartz (CRC Handbook of Chemistry and Physics)
AIR_VISCOSITY = 1.7894e-5  # Pa s, at 15 C (ISO 2533)
DRAG_COEFFICIENT = 0.44  # of a sphere, 1e3 < Re < 1e5 (Newton's law; Bird et al., 6.3)
SMALLEST_DIAMETER, LARGEST_DIAMETER = 1e-6, 1e-2  # m


def brownout(
    diameter: float = 100e-6,
    position: Any = (8.5, 0.0, 3.0),
    velocity: Any = (0.0, 1.0, 0.0),
    drag_coefficient: float | None = DRAG_COEFFICIENT,
) -> Problem:
    """A grain of sand under gravity, with the drag M (14) in the wind of `galvi.RotorDrag`.

    Parameters
    ----------
    diameter
        d of a sphere of quartz, in m, from 1e-6 to 1e-2; grains of sand have 10e-6 to 500e-6
    position : array, shape (3,)
        m from the foot of the rotor's axis, z up, above the ground
    velocity : array, shape (3,)
        m / s
    drag_coefficient
        C_d, constant as in M (14), which gives no value. The default 0.44 holds at higher Reynolds
        numbers than those of real grains: 200 micrometres at 3 to 9 m/s give Re from 40 to 125 and
        C_d = 24 / Re + 3.6 Re^-0.313 from 1.7 to 1. None: that C_d, of `galvi.SchillerNaumann`

    Raises
    ------
    ValueError
        For a diameter outside 1e-6 to 1e-2 m, a position below the ground, a shape other than (3,)
        or a drag coefficient that is not positive.

    Notes
    -----
    ``f = -(1/2) rho_air |w| w (pi d^2 / 4) C_d`` with w = v - wind(q, t), only C^1 at w = 0.
    There is no contact with the ground; the wind is tangential there.

    Examples
    --------
    >>> galvi.problems.brownout(diameter=2e-4).units
    "m, s, kg; z up from the ground, below the rotor's hub"
    """
    d = input_checks.positive("diameter", diameter, "Give it in metres.")
    if not SMALLEST_DIAMETER <= d <= LARGEST_DIAMETER:
        raise ValueError(
            f"diameter must be from {SMALLEST_DIAMETER:g} to {LARGEST_DIAMETER:g} m; "
            f"received {diameter!r}. Give it in metres: 100 micrometres are 100e-6."
        )
    drag = _drag(d, drag_coefficient)
    start = input_checks.array("position", position, (3,), "Give x, y and z in metres, z up.")
    speed = input_checks.array(
        "velocity", velocity, (3,), "Give x, y and z in metres a second, z up."
    )
    if start[2] < 0.0:
        raise ValueError(
            f"position must not be below the ground, z >= 0; received z = {start[2]:g}. Raise it."
        )
    mass = SAND_DENSITY * math.pi * d**3 / 6.0
    system = Canonical(
        mass, UniformField((0.0, 0.0, -mass * GRAVITY)), force=drag, timed_force=True
    )
    return Problem(
        system=system,
        q0=start,
        v0=speed,
        name=f"brownout, {d * 1e6:g} micrometres"
        + ("" if drag_coefficient is not None else ", Schiller-Naumann"),
        parameters={"diameter": d}
        | ({} if drag_coefficient is None else {"drag_coefficient": float(drag_coefficient)}),
        units="m, s, kg; z up from the ground, below the rotor's hub",
    )


def _drag(d: float, coefficient: float | None) -> RotorDrag:
    """The drag on a sphere of diameter d [m]."""
    if coefficient is None:
        return RotorDrag(
            3.0 * math.pi * AIR_VISCOSITY * d, SchillerNaumann(AIR_DENSITY * d / AIR_VISCOSITY)
        )
    coefficient = input_checks.positive("drag_coefficient", coefficient)
    return RotorDrag(0.5 * AIR_DENSITY * math.pi * d**2 / 4.0 * coefficient)
