"""Checks that a space with one degree per component fits a system."""

from __future__ import annotations

from typing import Any

from galvi.systems.canonical import Canonical


def checked_degrees(space: Any, system: Any, components: int) -> tuple[int, ...] | None:
    """The degree of each component; None for a space with a single degree.

    components  number of components of a velocity of the system

    Raises ValueError when the numbers of degrees and components differ, and for an NBody system.
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
