"""Moving frames and clocks: with forces, light bodies and hierarchies."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import galvi
from tests.agreement.row import Row, in_short_steps
from tests.properties.celestial_cases import CASES, WITH_ENERGY, bodies, eccentric
from tests.properties.clock_problems import CASES as CLOCKS
from tests.properties.clock_problems import (
    DAMPED,
    DRIVEN,
    DYNAMICAL,
    SUNDMAN,
    traced_clock,
    untraced_clock,
)
from tests.properties.test_frames import CASES as FRAMES
from tests.properties.test_kepler_frame import MOON, TREE

# ---------------------------------------------------------------- frames


def nested(planets: int) -> galvi.Problem:
    """A star and planets in three dimensions, in a random order."""
    random = np.random.default_rng(planets)
    radii = 1.0 + 0.9 * np.arange(planets) + random.uniform(0.0, 0.3, planets)
    angles, speeds = random.uniform(0.0, 6.0, planets), radii**-0.5
    q, v = np.zeros((2, planets + 1, 3))
    q[1:] = np.stack(
        [radii * np.cos(angles), radii * np.sin(angles), 0.05 * np.sin(3 * angles)], axis=1
    )
    v[1:, :2] = np.stack([-speeds * np.sin(angles), speeds * np.cos(angles)], axis=1)
    order = random.permutation(planets + 1)
    masses = np.append(1.0, np.full(planets, 1e-4))[order]
    return galvi.Problem(galvi.NBody(masses), q[order], v[order])


def partly_massless() -> galvi.Problem:
    outer = galvi.problems.outer_solar_system()
    masses = outer.system.masses * np.array([1.0, 1.0, 1.0, 0.0, 1.0, 0.0])
    return galvi.Problem(galvi.NBody(masses), outer.q0, outer.v0)


def in_frame(make: Any, step: float, frame: Any, gap_bound: float = 16.0) -> Row:
    return Row(make, step, "frame", 10, None, {"chart": frame}, gap_bound, in_short_steps)


WEAK = {**WITH_ENERGY, "power laws": (galvi.PowerLaw(1, -1e-5, 0.5), galvi.PowerLaw(0, 1e-2, -1))}
HIERARCHIES = {"planets": None, "pair and planet": ((0, 1), 2), "turned pair": ((1, 0), 2)}
IN_FRAMES: dict[str, Row] = {
    **{
        f"frame: {name}": in_frame(
            lambda problem=problem: problem, h, frame, 64.0 if "hierarchy" in name else 16.0
        )
        for name, (problem, frame, h) in FRAMES.items()
    },
    **{
        f"frame: {planets} planets": in_frame(partial(nested, planets), 1.2, galvi.KeplerFrame())
        for planets in (1, 2, 8, 9)
    },
    "frame: massless planets": in_frame(partly_massless, 400.0, galvi.KeplerFrame()),
    "frame: the Moon": in_frame(lambda: MOON, 5.0, galvi.KeplerFrame(hierarchy=TREE)),
    **{
        f"frame: {force}, {third_mass:g}, {hierarchy}{', plane' * plane}": in_frame(
            partial(bodies, WEAK[force], [1.0, 1e-3, third_mass], plane),
            0.5,
            galvi.KeplerFrame(hierarchy=HIERARCHIES[hierarchy]),
        )
        for i, force in enumerate(WEAK)
        for j, third_mass in enumerate((2e-4, 0.0))
        for k, hierarchy in enumerate(HIERARCHIES)
        for plane in (
            (i + j + k) % 3 == 0 and "J4" not in force,
        )  # J4's pole is inclined to the plane's normal
        if (i + k) % 3 < 2
    },
}

# ---------------------------------------------------------------- clocks

FORCES_BESIDE_GRAVITY: dict[str, Any] = {
    "none": (),
    "relativity": galvi.Relativity(12.0, form="potential"),
    "a logarithm": galvi.PowerLaw(0, -0.05, -1),
}


def heavy_bodies(forces: Any, masses: Any = (3.0, 4.0, 5.0), G: float = 1.3) -> galvi.Problem:
    """Bodies some two units apart, with velocity components of some 0.3."""
    rng, n = np.random.default_rng(11), len(masses)
    q = 1.5 * np.arange(n)[:, None] ** [[1.0, 0.5, 0.2]] + 0.2 * rng.normal(size=(n, 3))
    return galvi.Problem(galvi.NBody(masses, G, forces), q, 0.3 * rng.normal(size=(n, 3)))


def in_plane_orbit(system: Any) -> galvi.Problem:
    return galvi.Problem(system, [1.0, 0.0], [0.0, 0.8], 0.5)


def in_clock(make: Any, step: float, clock: Any, steps: int = 10, **options: Any) -> Row:
    return Row(make, step, "clock", steps, None, {"clock": clock}, **options)


def to_time(make: Any, step: float, clock: Any, duration: float, **options: Any) -> Row:
    """A row in a clock whose oracle is the motion in time."""
    return Row(
        make, step, "clock", None, duration, {"clock": clock}, oracle=in_short_steps, **options
    )


# These runs end near the pericentre, where rounding of the time changes the positions by 11 to
# 23 units of ROUND_OFF.
NEAR_PERICENTRE = {"Kepler, Sundman": 40.0}
UNTRACED = ("elastic pendulum",)  # its Lagrangian in tau cannot be traced
IN_CLOCKS: dict[str, Row] = {
    **{
        f"clock: {name}": in_clock(lambda problem=problem: problem, 0.5 * step, clock)
        for name, (problem, clock, _, step) in CLOCKS.items()
        if name not in UNTRACED
    },
    **{
        f"clock: three heavy bodies, {name}": in_clock(
            partial(heavy_bodies, force), 0.1, DYNAMICAL, slow=name != "none"
        )
        for name, force in FORCES_BESIDE_GRAVITY.items()
    },
    "clock: damped": in_clock(partial(in_plane_orbit, DAMPED), 0.2, SUNDMAN),
    **{
        f"clock: {name}": in_clock(partial(bodies, CASES[name]), 0.3, DYNAMICAL, 4, slow=True)
        for name in ("one source", "drag")
    },
    **{
        f"clock: relativity, step {step}": in_clock(
            partial(eccentric, galvi.Relativity(1e2)), step, DYNAMICAL, 6, gap_bound=32.0, slow=True
        )
        for step in (0.6, 1.9)
    },
}
IN_TIME: dict[str, Row] = {
    **{
        f"time: {name}": to_time(
            lambda problem=problem: problem,
            0.1,
            clock,
            duration,
            gap_bound=NEAR_PERICENTRE.get(name, 16.0),
            newton=name in UNTRACED,
            slow=name in UNTRACED,
        )
        for name, (problem, clock, duration, _) in CLOCKS.items()
    },
    "time: damped": to_time(partial(in_plane_orbit, DAMPED), 0.1, SUNDMAN, 1.5),
    "time: driven": to_time(
        partial(in_plane_orbit, DRIVEN), 0.1, SUNDMAN, 1.5, gap_bound=1000.0, slow=True
    ),
    **{
        f"time: {name}": to_time(
            partial(bodies, CASES[name]),
            0.1,
            DYNAMICAL,
            1.0,
            slow=name in ("one source", "a function of time", "Python", "a function"),
        )
        for name in CASES
        if name not in ("potential", "power laws", "radiation", "tides")
    },
    "time: free body": to_time(galvi.problems.free_body_se3, 0.1, galvi.Clock(traced_clock), 2.0),
    "time: free body, called": to_time(
        galvi.problems.free_body_se3, 0.1, galvi.Clock(untraced_clock), 2.0, newton=True, slow=True
    ),
}
ROWS = {**IN_FRAMES, **IN_CLOCKS, **IN_TIME}
