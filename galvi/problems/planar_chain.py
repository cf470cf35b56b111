"""A chain of rods swinging in a plane."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.groups.rn import Rn
from galvi.problem import Problem
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.planar_chain import PlanarChain


def planar_chain(
    links: int = 5,
    mass: float = 1.0,
    length: float = 1.0,
    gravity: float = 9.81,
    angle: float = 1.0,
) -> Problem:
    """Uniform rods hinged end to end, released in a straight line at rest.

    links         number of rods; the first is hinged to a fixed point
    mass, length  of each rod
    angle         initial angle of all rods from the downward vertical, in radians

    q_i is the angle of rod i against the vertical. Raises ValueError for fewer than one link, or a
    mass or length that is not positive.
    """
    n = input_checks.whole("links", links, at_most=1000)
    chain = PlanarChain(
        np.full(n, input_checks.positive("mass", mass)),
        np.full(n, input_checks.positive("length", length)),
        gravity,
        rods=True,
    )
    return Problem(
        system=Lagrangian(chain, Rn(n)),
        q0=np.full(n, input_checks.real("angle", angle)),
        v0=np.zeros(n),
        name=f"chain of {n} rods",
        parameters={"links": n, "mass": mass, "length": length, "gravity": chain.gravity,
                    "angle": angle},
        units="those of mass, length and gravity; angles in radians",
    )  # fmt: skip
