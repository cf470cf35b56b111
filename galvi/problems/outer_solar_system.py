"""The outer planets and Pluto about the Sun merged with the inner planets (H 2.4.3)."""

from __future__ import annotations

import math

import numpy as np

from galvi.problem import Problem
from galvi.problems.solar_system import solar_system
from galvi.systems.nbody import NBody

INNER = 5  # Sun, Mercury, Venus, Earth-Moon barycentre, Mars: one body here


def outer_solar_system() -> Problem:
    """Sun and inner planets as one body, Jupiter, Saturn, Uranus, Neptune, Pluto.

    The first body has the total GM of the Sun and the inner planets and their barycentric position
    and velocity, so that total mass, linear momentum and barycentre are those of `solar_system`, as
    are units, frame, epoch and source. The sums are correctly rounded: the initial state is
    bit-identical on every machine.
    """
    whole = solar_system()
    masses = whole.system.masses  # type: ignore[attr-defined]
    total = math.fsum(masses[:INNER])

    def aggregated(states: np.ndarray) -> np.ndarray:
        """(bodies, 3) with the first INNER rows replaced by their mass-weighted mean."""
        centre = [math.fsum(masses[:INNER] * x) / total for x in states[:INNER].T]
        return np.vstack([centre, states[INNER:]])

    return Problem(
        system=NBody(masses=np.append(total, masses[INNER:]), G=1.0),
        q0=aggregated(whole.q0),
        v0=aggregated(whole.v0),
        name="outer solar system",
        parameters={
            **whole.parameters,
            "bodies": ("Sun and inner planets", *whole.parameters["bodies"][INNER:]),
        },
        units=whole.units,
    )
