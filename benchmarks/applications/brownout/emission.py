"""Emission of grains from the ground by the wind: a threshold, a flux and its samples.

Friction speed, from the wind U at 1 m above the ground by the law of the wall, with von Karman's
constant 0.4 and a roughness of 1 mm:
    u* = 0.4 U / ln(1 m / 1 mm)
Threshold (Shao and Lu, J. Geophys. Res. 105 (2000) 22437):
    u_t = sqrt(0.0123 (rho_p g d / rho + 3e-4 kg/s^2 / (rho d)))
Flux along the ground (White, J. Geophys. Res. 84 (1979) 4643, with the constant 2.61 of later use):
    Q = 2.61 (rho / g) u*^3 (1 - u_t / u*) (1 + u_t / u*)^2
Flux upwards: alpha Q with alpha = 1e-3 /m, of soils from 1e-4 to 1e-2 (Gillette 1979; Marticorena
and Bergametti, J. Geophys. Res. 100 (1995) 16415).

The rotor's wind slides along the ground and has no layer of the wall, in which gusts lift grains.
So grains enter the wind anywhere in that layer, at a height between 0 and 1 m, upwards with the
speed u*, the size of a saltating grain's (Owen, J. Fluid Mech. 20 (1964) 225), and no other
velocity. Grains that entered on the ground would stay below the height at which the wind rises as
fast as they fall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.applications.brownout.philox import uniforms
from galvi.arrays import Array
from galvi.kernels.forces.rotor_wind import decay, rotor_wind
from galvi.problems.brownout import AIR_DENSITY, GRAVITY, SAND_DENSITY

KARMAN, ROUGHNESS, WALL_HEIGHT = 0.4, 1e-3, 1.0  # the last two in m
THRESHOLD_FACTOR, COHESION = 0.0123, 3e-4  # the latter in kg/s^2
FLUX_FACTOR = 2.61
UPWARD_FRACTION = 1e-3  # 1/m
INNER_RADIUS, OUTER_RADIUS = 0.5, 20.0  # m, from the axis: there is no emission elsewhere
MOST_ATTEMPTS = 2000  # to draw a grain
GRID_PANELS = 400  # panels of the quadrature in each direction


def friction_speed(r: Any, t: Any) -> Any:
    """u* in m/s at a distance from the axis in m and a time in s."""
    outwards = rotor_wind((r, 0.0 * r, WALL_HEIGHT), decay(t))[0]
    return KARMAN / math.log(WALL_HEIGHT / ROUGHNESS) * np.abs(outwards)


def threshold(diameter: float) -> float:
    """u_t in m/s of grains of quartz in air, of a diameter in m."""
    weight = SAND_DENSITY * GRAVITY * diameter / AIR_DENSITY
    return math.sqrt(THRESHOLD_FACTOR * (weight + COHESION / (AIR_DENSITY * diameter)))


def upward_flux(speed: Any, diameter: float, alpha: float = UPWARD_FRACTION) -> Any:
    """alpha Q in kg / (m^2 s) at a friction speed; 0 below the threshold."""
    threshold_speed = threshold(diameter)
    ratio = threshold_speed / np.maximum(speed, threshold_speed)
    return (
        alpha * FLUX_FACTOR * AIR_DENSITY / GRAVITY * speed**3 * (1.0 - ratio) * (1.0 + ratio) ** 2
    )


@dataclass(frozen=True)
class Emission:
    """Grains of one diameter that the wind lifts from 0 to a time.

    Attributes
    ----------
    diameter
        m
    until
        s
    share
        fraction of the ground that they cover
    """

    diameter: float
    until: float
    share: float = 1.0

    def density(self, r: Any, t: Any) -> Any:
        """kg / (m s) that leave rings of radius r at time t."""
        flux = upward_flux(friction_speed(r, t), self.diameter)
        return self.share * 2.0 * np.pi * r * flux

    @property
    def mass(self) -> float:
        """Total mass in kg, by the midpoint rule, to about 1e-5."""
        return (
            float(np.sum(_on_grid(self)))
            * (OUTER_RADIUS - INNER_RADIUS)
            * self.until
            / GRID_PANELS**2
        )

    def starts(self, grains: Any, seed: int = 1) -> tuple[Array, Array, Array]:
        """q (n, 3), v (n, 3) and t (n,) of grains with these numbers (n,), each of the same mass.

        Radius and time are sampled by rejection.

        Raises
        ------
        RuntimeError
            Where MOST_ATTEMPTS attempts do not suffice for a grain.
        """
        grains = np.asarray(grains, dtype=np.uint64)
        peak = 1.02 * float(np.max(_on_grid(self)))
        r, t, angle = (np.full(grains.shape, np.nan) for _ in range(3))
        z = WALL_HEIGHT * uniforms(grains, MOST_ATTEMPTS, seed)[0]
        pending = np.arange(grains.size)
        for attempt in range(MOST_ATTEMPTS):
            u = uniforms(grains[pending], attempt, seed)
            drawn_r, drawn_t = (
                INNER_RADIUS + (OUTER_RADIUS - INNER_RADIUS) * u[0],
                self.until * u[1],
            )
            accepted = u[2] * peak < self.density(drawn_r, drawn_t)
            new = pending[accepted]
            r[new], t[new], angle[new] = (
                drawn_r[accepted],
                drawn_t[accepted],
                2.0 * np.pi * u[3][accepted],
            )
            pending = pending[~accepted]
            if not pending.size:
                break
        else:
            raise RuntimeError(
                f"no place and time was drawn for {pending.size} grains of {self.diameter:g} m in "
                f"{MOST_ATTEMPTS} attempts: the wind does not lift them, or hardly. Leave them out."
            )
        q = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
        v = np.zeros(q.shape)
        v[:, 2] = friction_speed(r, t)
        return q, v, t


@lru_cache(maxsize=32)
def _on_grid(emission: Emission) -> Array:
    """The emission's density at the middles of a grid of GRID_PANELS^2 rectangles in (r, t)."""
    middles = (np.arange(GRID_PANELS) + 0.5) / GRID_PANELS
    r = INNER_RADIUS + (OUTER_RADIUS - INNER_RADIUS) * middles
    return emission.density(r[:, None], emission.until * middles[None, :])
