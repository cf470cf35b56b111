"""Sun, planets and Pluto from JPL's DE421 at the start of 2000 (H 2.4.3)."""

from __future__ import annotations

from importlib import resources

import numpy as np

from galvi.problem import Problem
from galvi.systems.nbody import NBody

EPOCH = "JD 2451544.5 TDB"
SOURCE = "JPL DE421"


def solar_system(pluto: bool = True) -> Problem:
    """Sun, Mercury, Venus, Earth-Moon barycentre, ..., Neptune and, by default, Pluto.

    Barycentric states of 2000-01-01 in the frame of the ICRF, in au and days of TDB. ``masses`` are
    GM in au^3/day^2 and G = 1, so p = GM v. The states are unchanged from JPL, so the barycentre
    of these point masses moves slightly. The file is made by ``python -m references.jpl.states``.
    """
    text = (resources.files("galvi") / "problems" / "data" / "solar_system.csv").read_text("ascii")
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")][1:]
    bodies = tuple(row[0] for row in rows)
    numbers = np.array([[float(x) for x in row[1:]] for row in rows])
    if not pluto:
        bodies, numbers = bodies[:-1], numbers[:-1]
    return Problem(
        system=NBody(masses=numbers[:, 0], G=1.0),
        q0=numbers[:, 1:4],
        v0=numbers[:, 4:7],
        name="solar system" if pluto else "solar system without Pluto",
        parameters={"bodies": bodies, "epoch": EPOCH, "source": SOURCE},
        units="au, day (TDB); masses are GM in au^3/day^2 and G = 1",
    )
