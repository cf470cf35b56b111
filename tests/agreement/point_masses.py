"""Point masses: in the plane and in space, massless ones, and with forces beside gravity."""

from __future__ import annotations

from functools import partial
from typing import Any

import galvi
from tests.agreement.row import Row
from tests.properties.celestial_cases import CASES, MASSES, OF_VELOCITY, Q, V, bodies

PLANAR_FORCES = [f for name in ("EIH", "radiation", "drag", "power laws") for f in CASES[name]]
POWERS = (-4, -3, -2.5, -2, 0.25, 1, 2, 7, -2.13, 0.7, 40.3)


def planets(plane: bool = False, **options: int) -> galvi.Problem:
    """All planets; with ``particles``, the outer planets and as many massless bodies."""
    make = galvi.problems.outer_solar_system if options else galvi.problems.solar_system
    problem = make(**options)
    dimension = 2 if plane else 3
    return problem.with_initial_state(problem.q0[:, :dimension], problem.v0[:, :dimension])


def forced(name: str, plane: bool = False) -> galvi.Problem:
    """Three bodies with forces; the last is massless where the forces allow it."""
    masses = MASSES if name in OF_VELOCITY else [1.0, 1e-3, 0.0]
    return bodies(CASES[name], masses, plane)


def with_force(force: Any, v: Any = V) -> galvi.Problem:
    return galvi.Problem(galvi.NBody(MASSES, forces=force), Q, v)


def dragged(power: float) -> galvi.Problem:
    """Three bodies at rest, where the drag has no direction."""
    return with_force(galvi.Drag([1e-3] * 3, power), 0.0 * V)


def in_power_law(power: float) -> galvi.Problem:
    return with_force(galvi.PowerLaw(0, -(0.1 ** (2 + abs(power) / 3)), power))


PLANE_BY_SUFFIX = {"": False, ", in the plane": True}
ROWS: dict[str, Row] = {
    **{
        f"planets{name}": Row(partial(planets, plane), 3.0)
        for name, plane in PLANE_BY_SUFFIX.items()
    },
    **{
        f"planets and massless bodies{name}": Row(partial(planets, plane, particles=2), 200.0)
        for name, plane in PLANE_BY_SUFFIX.items()
    },
    **{
        f"forces: {force}": Row(
            partial(forced, force), 0.05, slow=force in ("a function of time", "Python")
        )
        for force in CASES
        if force != "a function"
    },
    "forces: one source, in the plane": Row(partial(forced, "one source", True), 0.05),
    "forces: others, in the plane": Row(partial(bodies, PLANAR_FORCES, plane=True), 0.05),
    **{
        f"drag by |v|^{power} from rest": Row(partial(dragged, power), 0.02)
        for power in (0.5, 1.0, 2.0, 3.0)
    },
    **{
        f"force by r^{power}": Row(partial(in_power_law, power), 0.01, steps=5, gap_bound=4.0)
        for power in POWERS
    },
}
