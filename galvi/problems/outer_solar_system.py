"""The outer planets and Pluto about the Sun merged with the inner planets (H 2.4.3)."""

from __future__ import annotations

import math

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.problem import Problem
from galvi.problems.solar_system import solar_system
from galvi.systems.nbody import NBody

INNER = 5  # Sun, Mercury, Venus, Earth-Moon barycentre, Mars: one body here


NEAREST, FARTHEST = 42.0, 48.0  # au, the classical Kuiper belt
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


def outer_solar_system(particles: int = 0) -> Problem:
    """Sun and inner planets as one body, Jupiter, Saturn, Uranus, Neptune, Pluto.

    particles  massless bodies behind them, on circular orbits about the barycentre 42 to 48 au away
               in the plane normal to the total angular momentum, a golden angle apart

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

    count = input_checks.whole("particles", particles, 0)
    q0, v0, heavy = aggregated(whole.q0), aggregated(whole.v0), np.append(total, masses[INNER:])
    q, v = _belt(count, heavy, q0, v0)
    names = ("Sun and inner planets", *whole.parameters["bodies"][INNER:])
    return Problem(
        system=NBody(masses=np.append(heavy, np.zeros(count)), G=1.0),
        q0=np.vstack([q0, q]),
        v0=np.vstack([v0, v]),
        name=f"outer solar system{f' and {count} massless bodies' if count else ''}",
        parameters={
            **whole.parameters,
            "bodies": (*names, *(f"particle {k + 1}" for k in range(count))),
        },
        units=whole.units,
    )


def _belt(count: int, masses: Array, q0: Array, v0: Array) -> tuple[Array, Array]:
    """Positions and velocities (count, 3) of the massless bodies."""
    normal = np.cross(q0, masses[:, None] * v0).sum(axis=0)
    normal /= np.linalg.norm(normal)
    east = np.cross(normal, [0.0, 0.0, 1.0])
    east /= np.linalg.norm(east)
    north = np.cross(normal, east)
    k = np.arange(count)
    far = NEAREST + (FARTHEST - NEAREST) * (k + 0.5) / max(count, 1)
    cosine, sine = np.cos(GOLDEN_ANGLE * k), np.sin(GOLDEN_ANGLE * k)
    place = far[:, None] * (np.outer(cosine, east) + np.outer(sine, north))
    speed = np.sqrt(masses.sum() / far)
    return place, speed[:, None] * (np.outer(cosine, north) - np.outer(sine, east))
