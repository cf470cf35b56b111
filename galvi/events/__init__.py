"""Ready events: ``galvi.events.closest_approach(i, j)`` and others.

Each function returns a `galvi.Event`, for `galvi.integrate` and `galvi.find_events`; its docstring
says which value the event reports. Bodies are given by number or by the names in
``problem.parameters["bodies"]``, joints by their entry of q or by the names that a tree gives its
hinges and slides.

An example:

>>> galvi.events.apsis("planet", "star").name
'apsis of planet about star'
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.events.event import ANY, Angle, Approach, Distances, Event, Plane, Transit
from galvi.input_checks import shown

__all__ = [
    "angle",
    "apsis",
    "closest_approach",
    "plane_crossing",
    "section",
    "transit",
    "within",
]


def closest_approach(i: Any, j: Any) -> Event:
    """The distance of two bodies is at a local minimum; value: their distance."""
    return Event(Approach(i, j), 1, name=f"closest approach of {i} and {j}")


def within(
    i: Any, j: Any, distance: float | None = None, *, hill_radii: float | None = None
) -> Event:
    """Two bodies come within a distance, or leave it; value: their distance.

    Parameters
    ----------
    i, j
        bodies; "any" for all: pairs are searched together, and each event is named by its pair
    distance
        the distance; give either this or ``hill_radii``
    hill_radii
        the distance in Hill radii of the pair at that time, ((m_i + m_j) / (3 M))^(1/3)
        (r_i + r_j) / 2 about the heaviest body, of mass M, which is then in no pair
    """
    if (distance is None) == (hill_radii is None):
        received = "neither" if distance is None else "both"
        raise ValueError(f"give either distance or hill_radii; received {received}.")
    if distance is not None:
        threshold, in_hill_radii = input_checks.positive("distance", distance), False
    else:
        threshold, in_hill_radii = input_checks.positive("hill_radii", hill_radii), True
    distances = Distances(i, j, threshold, in_hill_radii)
    if any(isinstance(body, str) and body == ANY for body in (i, j)):
        return Event(distances, 0, name=distances.name_of(i, j))
    return Event(distances.one_of(i, j), 0, name=distances.name_of(i, j))


def apsis(i: Any, about: Any) -> Event:
    """The distance of a body from another is at a local minimum or maximum; value: that
    distance."""
    return Event(Approach(i, about), 0, name=f"apsis of {i} about {about}")


def transit(i: Any, j: Any, observer: Any) -> Event:
    """Body i, in front of j, is nearest to it on the sky; value: their distance there.

    Parameters
    ----------
    observer
        direction from the bodies to a distant observer, with a component for each dimension
    """
    direction = _direction("observer", observer)
    return Event(Transit(i, j, direction), 1, name=f"transit of {i} in front of {j}")


def plane_crossing(normal: Any, offset: float = 0.0, body: Any = None) -> Event:
    """A particle, or ``body`` of several, crosses the plane normal . q = offset.

    Value: normal . q - offset.
    """
    direction = _direction("normal", normal)
    return Event(
        Plane(direction, input_checks.real("offset", offset), body), 0, name="plane crossing"
    )


def angle(joint: Any, value: float) -> Event:
    """The coordinate of a joint, by name or entry of q, passes an angle up to whole turns; value:
    the coordinate."""
    return Event(
        Angle(joint, input_checks.real("value", value)), 0, name=f"joint {joint} at {value:g}"
    )


def section(function: Callable[..., Any]) -> Event:
    """function(q, v, t) rises through zero (a Poincare section); value: the function there."""
    return Event(function, 1, name="section")


def _direction(name: str, vector: Any) -> tuple[float, ...]:
    components = input_checks.array(name, vector)
    if components.ndim != 1 or not np.any(components):
        raise ValueError(f"{name} must be a vector other than 0; received {shown(vector)}.")
    return tuple(components.tolist())
