"""Point masses that meet: problems whose truths are stored, as they need quadruple precision."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from galvi import NBody, Problem

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))  # radians
ASTRONOMICAL_UNITS = "au, solar mass, year / 2 pi"


def burrau() -> Problem:
    """Three bodies of masses 3, 4 and 5, at rest opposite the sides of these lengths."""
    positions = [[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]]
    return Problem(NBody([3.0, 4.0, 5.0]), positions, np.zeros((3, 2)), name="Burrau's problem")


def _orbit(a: float, e: float, mass: float, tilt: float, turn: float) -> tuple[Any, Any]:
    """Position and velocity at the apocentre relative to a central mass, (3,) each: rotated by
    ``turn`` in the plane, then by ``tilt`` about x."""
    r, speed = a * (1.0 + e), math.sqrt(mass / a * (1.0 - e) / (1.0 + e))
    q, v = np.array([-r, 0.0, 0.0]), np.array([0.0, -speed, 0.0])
    c, s, ct, st = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, ct, -st], [0.0, st, ct]])
    return tilted @ turned @ q, tilted @ turned @ v


def _balanced(masses: Any, q: Any, v: Any, name: str, units: str, bodies: Any) -> Problem:
    """The problem in the frame of its centre of mass, G = 1."""
    m, q, v = (np.array(x, dtype=np.float64) for x in (masses, q, v))
    q, v = q - m @ q / m.sum(), v - m @ v / m.sum()
    return Problem(NBody(m), q, v, name=name, units=units, parameters={"bodies": bodies})


def hd_80606() -> Problem:
    """A planet of e = 0.933, as that of HD 80606, and a companion of Jupiter's mass at 3 au."""
    star, planet, companion = 1.05, 3.9e-3, 9.5e-4
    planet_state = _orbit(0.4565, 0.9332, star + planet, 0.0, 0.0)
    companion_state = _orbit(3.0, 0.1, star + planet + companion, math.radians(10.0), 1.0)
    zero = (np.zeros(3), np.zeros(3))
    q, v = zip(zero, planet_state, companion_state, strict=True)
    masses = [star, planet, companion]
    return _balanced(
        masses,
        q,
        v,
        "HD 80606 and a companion",
        ASTRONOMICAL_UNITS,
        ("star", "planet", "companion"),
    )


def kozai_triple() -> Problem:
    """A planet whose orbit a star at 6 au, inclined by 75 degrees, periodically makes eccentric."""
    star, planet, outer = 1.0, 1e-3, 1.0
    planet_state = _orbit(1.0, 0.05, star + planet, math.radians(75.0), 0.3)
    outer_state = _orbit(6.0, 0.0, star + planet + outer, 0.0, 0.0)
    inner = planet / (star + planet)
    q = [-inner * planet_state[0], (1.0 - inner) * planet_state[0], outer_state[0]]
    v = [-inner * planet_state[1], (1.0 - inner) * planet_state[1], outer_state[1]]
    return _balanced(
        [star, planet, outer],
        q,
        v,
        "Kozai-Lidov cycles",
        ASTRONOMICAL_UNITS,
        ("star", "planet", "other star"),
    )


def binary_meets_star() -> Problem:
    """A third star flies through a circular binary of equal stars."""
    position, velocity = np.array([0.5, 0.0, 0.0]), np.array([0.0, math.sqrt(2.0) / 2.0, 0.0])
    q, v = [-position, position, [-1.1, 12.0, 0.2]], [-velocity, velocity, [0.05, -0.8, 0.0]]
    return _balanced([1.0, 1.0, 1.0], q, v, "a binary meets a star", "G = 1", (0, 1, 2))


def sixteen_stars() -> Problem:
    """Equal stars in Plummer's density, placed along spirals, total mass 1 and G = 1."""
    n = 16
    k = np.arange(n)
    share = (k + 0.5) / n
    radius = 1.0 / np.sqrt(share ** (-2.0 / 3.0) - 1.0)
    height, angle = 1.0 - 2.0 * ((k * 7) % n + 0.5) / n, GOLDEN_ANGLE * k
    flat = np.sqrt(1.0 - height**2)
    q = radius[:, None] * np.stack([flat * np.cos(angle), flat * np.sin(angle), height], axis=1)
    speed = 0.45 * math.sqrt(2.0) * (1.0 + radius**2) ** -0.25
    up, turn = 1.0 - 2.0 * ((k * 11 + 5) % n + 0.5) / n, GOLDEN_ANGLE * (3 * k + 2) + 1.0
    level = np.sqrt(1.0 - up**2)
    v = speed[:, None] * np.stack([level * np.cos(turn), level * np.sin(turn), up], axis=1)
    return _balanced(np.full(n, 1.0 / n), q, v, "16 stars", "G = 1", tuple(range(n)))


def sitnikov() -> Problem:
    """A massless body on the axis of a binary of e = 0.6."""
    e = 0.6
    speed = math.sqrt((1.0 - e) / (1.0 + e)) / 2.0
    q = [[-0.5 * (1.0 + e), 0.0, 0.0], [0.5 * (1.0 + e), 0.0, 0.0], [0.0, 0.0, 0.6]]
    v = [[0.0, -speed, 0.0], [0.0, speed, 0.0], [0.0, 0.0, 0.2]]
    return Problem(
        NBody([0.5, 0.5, 0.0]),
        q,
        v,
        name="Sitnikov's problem",
        units="G = 1",
        parameters={"bodies": (0, 1, "massless body")},
    )


def third_body(mass: float) -> Problem:
    """A body of this mass on a close orbit about one of two stars, which sets a clock's pace."""
    q = [[0.0, 0.0, 0.0], [9.0, 4.0, 1.0], [0.2, 0.0, 0.05]]
    v = [[0.0, 0.0, 0.0], [-0.15, 0.3, 0.1], [0.0, 2.9, 0.3]]
    return Problem(
        NBody([1.0, 0.5, mass]),
        q,
        v,
        name=f"third body of mass {mass:g}",
        units="G = 1",
        parameters={"bodies": ("star", "other star", "third body")},
    )


THIRD_BODIES = {f"third_body_{mass:g}": mass for mass in (1e-3, 1e-6, 1e-9, 1e-12, 0.0)}


ENCOUNTERS: Mapping[str, tuple[Callable[[], Problem], float]] = {  # file: problem, horizon
    "burrau": (burrau, 63.0),
    "hd_80606": (hd_80606, 100.0 * 2.0 * math.pi),
    "kozai": (kozai_triple, 1000.0 * 2.0 * math.pi),
    "binary_meets_star": (binary_meets_star, 60.0),
    "sixteen_stars": (sixteen_stars, 6.0 * math.sqrt(2.0)),
    "sitnikov": (sitnikov, 200.0),
    **{name: (partial(third_body, mass), 20.0) for name, mass in THIRD_BODIES.items()},
}
