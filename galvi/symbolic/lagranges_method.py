"""What SymPy's LagrangesMethod holds: a Lagrangian, its coordinates, and forces."""

from __future__ import annotations

from typing import Any

NAME = "LagrangesMethod"


def is_lagranges_method(value: Any) -> bool:
    """Whether a value is a `sympy.physics.mechanics.LagrangesMethod`, without importing that."""
    return any(
        kind.__name__ == NAME and kind.__module__.startswith("sympy.") for kind in type(value).mro()
    )


def read_lagranges_method(method: Any) -> tuple[Any, list[Any], list[Any] | None]:
    """L, the coordinates, and the generalised forces of its loads, or None.

    A load on a point or a frame has the force F . dv/dq' with its velocity, or angular velocity, v.
    Raises ValueError for one with constraints.
    """
    if len(method.coneqs):
        raise ValueError(
            f"a LagrangesMethod with constraints cannot be used; received {len(method.coneqs)} of "
            f"them. Choose coordinates that fulfil them."
        )
    (lagrangian,) = method._L
    coordinates = list(method.q)
    if not method.forcelist:
        return lagrangian, coordinates, None
    time = coordinates[0].args[0]
    rates = [x.diff(time) for x in coordinates]
    forces: list[Any] = [0] * len(coordinates)
    for place, load in method.forcelist:
        velocity = getattr(place, "ang_vel_in" if hasattr(place, "ang_vel_in") else "vel")
        moving = velocity(method.inertial)
        for k, rate in enumerate(rates):
            along = moving.diff(rate, method.inertial, var_in_dcm=False)
            forces[k] += along.dot(load)
    return lagrangian, coordinates, forces
