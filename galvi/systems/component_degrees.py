"""Whether a space with a degree for each component fits a system."""

from __future__ import annotations

from typing import Any

from galvi.systems.canonical import Canonical


def checked_degrees(space: Any, system: Any, components: int) -> tuple[int, ...] | None:
    """The degrees of the space's components; None when they share one space.

    components  of a velocity of the system

    Raises ValueError for another number of them, and for a system that allows no such space.
    """
    degrees: tuple[int, ...] | None = getattr(space, "degrees", None)
    if degrees is None:
        return None
    if len(degrees) != components:
        raise ValueError(
            f"the space must have a degree for each of the {components} components; received "
            f"{len(degrees)} degrees, {degrees}."
        )
    if not (hasattr(system, "group") or isinstance(system, Canonical)):
        raise ValueError(
            f"degrees for each component are for Canonical and Lagrangian systems; received a "
            f"{type(system).__name__} system. Use galvi.Polynomials."
        )
    return degrees
