"""The stated model of a brownout cloud: grains of five sizes in the wind of a landing rotor.

Each super-particle stands for many grains: its mass is that which the wind lifts of its size until
the end, divided by the number of super-particles of this size. They neither meet nor move the air,
as in M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import galvi
from benchmarks.applications.brownout.emission import Emission
from benchmarks.applications.brownout.flights import Flights, Ground, follow
from galvi.arrays import Array
from galvi.problems.brownout import DRAG_COEFFICIENT, GRAVITY, SAND_DENSITY

DIAMETERS = (10e-6, 50e-6, 100e-6, 200e-6, 400e-6)  # m
END_TIME = 6.0  # s; the rotor has come from 16 m down to 6.5 m
CONSTANT_DRAG, REYNOLDS_DRAG = "C_d = 0.44", "Schiller-Naumann"
DRAG_COEFFICIENTS = {CONSTANT_DRAG: DRAG_COEFFICIENT, REYNOLDS_DRAG: None}
PILOT_EYE, SIGHT_TARGET = (2.0, 4.5), (15.0, 0.0)  # r and z in m; the target is on the ground
RAY_HALF_WIDTH = 0.25  # m, of the pencil of rays
EXTINCTION = 2.0  # cross-sections that a grain removes from a ray, much larger than a wavelength


@dataclass(frozen=True)
class Cloud:
    """Super-particles of one diameter.

    Attributes
    ----------
    diameter
        m
    drag
        CONSTANT_DRAG or REYNOLDS_DRAG
    grains
        identifying numbers of the super-particles, (n,)
    ground
        effect of a contact with the ground
    """

    diameter: float
    drag: str = REYNOLDS_DRAG
    grains: Any = field(default_factory=lambda: np.arange(1000))
    ground: Ground = field(default_factory=Ground)

    @property
    def problem(self) -> Any:
        """The problem of a single grain, from which the drag is taken."""
        return galvi.problems.brownout(self.diameter, drag_coefficient=DRAG_COEFFICIENTS[self.drag])

    @property
    def emission(self) -> Emission:
        """Emitted grains, equal ground cover for each size."""
        return Emission(self.diameter, END_TIME, 1.0 / len(DIAMETERS))

    @property
    def rates(self) -> tuple[Any, Array]:
        """The drag law, and an array of its factor over the mass and its numbers."""
        system = self.problem.system
        law = system.force.drag_law
        return law, np.array([system.force.factor / float(system.mass), *law.numbers])

    def starts(self) -> tuple[Array, Array, Array]:
        """q, v and t of the grains."""
        return self.emission.starts(self.grains)

    def flights(
        self, method: Any, steps: int, saves: int = 0, threads: int | None = None
    ) -> Flights:
        """The flights in `steps` steps from 0 to END_TIME."""
        q, v, t = self.starts()
        law, rates = self.rates
        return follow(
            method,
            q,
            v,
            t,
            np.tile(rates, (t.size, 1)),
            law,
            END_TIME / steps,
            END_TIME,
            gravity=GRAVITY,
            saves=saves,
            ground=self.ground,
            threads=threads,
        )


def optical_depth(q: Array, diameter: float) -> Array:
    """The share (n,) of each super-particle in the optical depth of the pilot's ray, for 1 kg each.

    The model is axisymmetric, so that a super-particle stands for a ring. A ray in a plane through
    the axis sees tau = sum m / (m_grain 2 pi r) 2 (pi d^2 / 4) delta(distance to the ray), with a
    triangle of half width RAY_HALF_WIDTH for delta. Grains on the ground do not count.
    """
    r, z = np.hypot(q[:, 0], q[:, 1]), q[:, 2]
    along = np.subtract(SIGHT_TARGET, PILOT_EYE)
    length = float(np.hypot(*along))
    e = along / length
    ahead = (r - PILOT_EYE[0]) * e[0] + (z - PILOT_EYE[1]) * e[1]
    aside = np.abs((r - PILOT_EYE[0]) * e[1] - (z - PILOT_EYE[1]) * e[0])
    triangle = np.maximum(0.0, 1.0 - aside / RAY_HALF_WIDTH) / RAY_HALF_WIDTH
    weight = triangle * ((ahead > 0.0) & (ahead < length) & (z > 0.0))
    grain = SAND_DENSITY * math.pi * diameter**3 / 6.0
    area = EXTINCTION * math.pi * diameter**2 / 4.0
    return area / grain * weight / (2.0 * np.pi * np.maximum(r, 1e-9))
