"""Problems of point masses: any number of planets, and two bodies, the light one first."""

from __future__ import annotations

import math

import numpy as np

import galvi
from galvi import NBody, Problem

AXIS_RATIO = (
    1.1  # of neighbouring orbits: 11 mutual Hill radii of the heaviest, so that none come close
)
MASS_FACTOR = 1e-3  # factor on the masses of Jupiter, Saturn, Uranus, Neptune, used cyclically
ECCENTRICITY = 0.02  # also the inclination in radians
SEED = 1986


def many_planets(bodies: int, massive: int | None = None) -> Problem:
    """A Sun and bodies - 1 light planets, the innermost at Jupiter's orbit, each next farther out.

    Parameters
    ----------
    massive
        number of bodies with mass, the Sun included; outer ones are massless. None: all have mass

    Notes
    -----
    A planet has the same initial position in every system, up to the barycentre.
    Units are those of `galvi.problems.solar_system`. ValueError for fewer than two bodies.
    """
    if bodies < 2:
        raise ValueError(f"bodies must be at least 2, a Sun and a planet; received {bodies}.")
    giants = galvi.problems.outer_solar_system()
    sun, *heavy = giants.system.masses[:5]  # type: ignore[attr-defined]
    gap = giants.q0[1] - giants.q0[0]
    numbers = np.arange(bodies - 1)
    masses = MASS_FACTOR * np.array(heavy)[numbers % len(heavy)]
    axes = float(np.linalg.norm(gap)) * AXIS_RATIO**numbers
    angles = np.stack(
        [np.random.default_rng([SEED, int(k)]).uniform(0.0, math.tau, 3) for k in numbers]
    )
    planets = [_orbit(axis, sun, angle) for axis, angle in zip(axes, angles, strict=True)]
    q = np.vstack([np.zeros(3), *(position for position, _ in planets)])
    v = np.vstack([np.zeros(3), *(velocity for _, velocity in planets)])
    all_masses = np.append(sun, masses)
    all_masses[massive:] = 0.0 if massive else all_masses[massive:]
    q -= all_masses @ q / all_masses.sum()
    v -= all_masses @ v / all_masses.sum()
    return Problem(NBody(all_masses), q, v, name=f"{bodies} bodies", units=giants.units)


def innermost_period(problem: Problem) -> float:
    """The period of the innermost planet of `many_planets` about the Sun, without its mass."""
    giants = galvi.problems.outer_solar_system()
    axis = float(np.linalg.norm(giants.q0[1] - giants.q0[0]))
    sun = float(problem.system.masses[0])  # type: ignore[attr-defined]
    return math.tau * math.sqrt(axis**3 / sun)


def _orbit(axis: float, gm: float, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity at pericentre; angles are the node and two whose sum is the argument of
    pericentre."""
    node, argument, angle = angles
    across = np.array([math.cos(argument + angle), math.sin(argument + angle), 0.0])
    along = np.array([-across[1], across[0], 0.0])
    tilt = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, math.cos(ECCENTRICITY), -math.sin(ECCENTRICITY)],
            [0.0, math.sin(ECCENTRICITY), math.cos(ECCENTRICITY)],
        ]
    )
    swing = np.array(
        [
            [math.cos(node), -math.sin(node), 0.0],
            [math.sin(node), math.cos(node), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    orientation = swing @ tilt
    speed = math.sqrt(gm / axis * (1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))
    return axis * (1.0 - ECCENTRICITY) * orientation @ across, speed * orientation @ along


PAIR = galvi.Problem(
    galvi.NBody([1e-3, 0.9], G=1.2),
    [[1.0, 0.2, 0.0], [0.0, 0.1, 0.0]],
    [[0.0, 0.9, 0.1], [0.0, 0.0, 0.0]],
    name="two bodies, the light one first",
)
