"""Systems of bodies: published starts, any number of planets, a light body first."""

from __future__ import annotations

import math

import numpy as np

import galvi
from galvi import NBody, Problem

# JPL DE421 at JD 2440400.5, by references.jpl.states.ephemeris: GM, place and velocity, in au and
# days; the Sun has the inner planets' GM, place and momentum, summed correctly rounded.
EPOCH = 2440400.5
BODIES = {
    "Sun and inner planets": (
        0.00029591397695294787, 0.004504373687576187, 0.0007629620793496095,
        0.00026414802859411684, -2.6859306563195593e-07, 5.225351295004562e-06,
        2.2489495311041808e-06,
    ),
    "Jupiter": (
        2.82534584085505e-07, -5.379706768297444, -0.8304814016092147, -0.22482876556029507,
        0.0010920126252574368, -0.006518116677554969, -0.0028207825773521157,
    ),
    "Saturn": (
        8.459706073308477e-08, 7.894390677484482, 4.596478075225196, 1.5586958187474582,
        -0.003217556522901148, 0.004335810343902022, 0.0019286463028107296,
    ),
    "Uranus": (
        1.29202482579265e-08, -18.265400343728217, -1.1619572328839993, -0.2501044321909807,
        0.00022119027863849825, -0.0037624755734531386, -0.001651014251322349,
    ),
    "Neptune": (
        1.52435910924974e-08, -16.05504055116263, -23.94218959225165, -9.400156803383407,
        0.0026427703618792427, -0.001498312896391299, -0.0006790418405641149,
    ),
    "Pluto": (
        2.17844105199052e-12, -30.483317419840724, -0.8724200870812093, 8.911584507557775,
        0.0003222085271044289, -0.0031435756754003064, -0.0010779506297515329,
    ),
}  # fmt: skip


def outer_planets_of_1969() -> Problem:
    """Sun, outer planets and Pluto on 28 June 1969."""
    table = np.array(list(BODIES.values()))
    return Problem(
        NBody(table[:, 0]), table[:, 1:4], table[:, 4:], name="outer planets of 1969",
        parameters={"bodies": tuple(BODIES)}, units="au, day",
    )  # fmt: skip


def regular_henon_heiles() -> Problem:
    """Henon-Heiles with H = 1/12 from q = (0, 0.3), p_2 = 0.2: a motion on a torus.

    As Hairer, McLachlan and Razakarivony (2008) take it.
    """
    problem = galvi.problems.henon_heiles()
    y, v = 0.3, 0.2
    resting = 0.5 * y**2 - y**3 / 3.0 + 0.5 * v**2
    return problem.with_initial_state(
        np.array([0.0, y]), np.array([math.sqrt(2.0 * (1.0 / 12.0 - resting)), v])
    )


SPACING = 1.1  # of neighbouring orbits: 11 mutual Hill radii of the heaviest, so none come close
LIGHTER = 1e-3  # factor on the masses of Jupiter, Saturn, Uranus, Neptune, used cyclically
ROUND = 0.02  # eccentricity and inclination, in radians
SEED = 1986


def many_planets(bodies: int, massive: int | None = None) -> Problem:
    """A Sun and bodies - 1 light planets, the innermost at Jupiter's orbit, each next farther out.

    massive  the number of bodies that have a mass, the outer ones have none; None: all

    A planet has the same initial position in every system, up to the barycentre.
    Units are those of `galvi.problems.solar_system`. ValueError for fewer than two bodies.
    """
    if bodies < 2:
        raise ValueError(f"bodies must be at least 2, a Sun and a planet; received {bodies}.")
    giants = galvi.problems.outer_solar_system()
    sun, *heavy = giants.system.masses[:5]  # type: ignore[attr-defined]
    gap = giants.q0[1] - giants.q0[0]
    numbers = np.arange(bodies - 1)
    masses = LIGHTER * np.array(heavy)[numbers % len(heavy)]
    axes = float(np.linalg.norm(gap)) * SPACING**numbers
    angles = np.stack(
        [np.random.default_rng([SEED, int(k)]).uniform(0.0, math.tau, 3) for k in numbers]
    )
    planets = [_orbit(axis, sun, angle) for axis, angle in zip(axes, angles, strict=True)]
    q = np.vstack([np.zeros(3), *(place for place, _ in planets)])
    v = np.vstack([np.zeros(3), *(velocity for _, velocity in planets)])
    every = np.append(sun, masses)
    every[massive:] = 0.0 if massive else every[massive:]
    q -= every @ q / every.sum()
    v -= every @ v / every.sum()
    return Problem(NBody(every), q, v, name=f"{bodies} bodies", units=giants.units)


def innermost_period(problem: Problem) -> float:
    """The period of the first planet about the Sun, with the axis given by `many_planets`."""
    giants = galvi.problems.outer_solar_system()
    axis = float(np.linalg.norm(giants.q0[1] - giants.q0[0]))
    sun = float(problem.system.masses[0])  # type: ignore[attr-defined]
    return math.tau * math.sqrt(axis**3 / sun)


def _orbit(axis: float, gm: float, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity at pericentre for the angles (longitude, node, argument)."""
    node, argument, turn = angles
    across = np.array([math.cos(argument + turn), math.sin(argument + turn), 0.0])
    along = np.array([-across[1], across[0], 0.0])
    tilt = np.array(
        [[1.0, 0.0, 0.0], [0.0, math.cos(ROUND), -math.sin(ROUND)],
         [0.0, math.sin(ROUND), math.cos(ROUND)]]
    )  # fmt: skip
    swing = np.array(
        [[math.cos(node), -math.sin(node), 0.0], [math.sin(node), math.cos(node), 0.0],
         [0.0, 0.0, 1.0]]
    )  # fmt: skip
    turned = swing @ tilt
    speed = math.sqrt(gm / axis * (1.0 + ROUND) / (1.0 - ROUND))
    return axis * (1.0 - ROUND) * turned @ across, speed * turned @ along


PAIR = galvi.Problem(
    galvi.NBody([1e-3, 0.9], G=1.2),
    [[1.0, 0.2, 0.0], [0.0, 0.1, 0.0]],
    [[0.0, 0.9, 0.1], [0.0, 0.0, 0.0]],
    name="two bodies, the light one first",
)
