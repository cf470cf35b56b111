"""Converts a chain of links to MuJoCo: nested bodies, each on a hinge about y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import PlanarChain
from galvi.arrays import Array
from references.mujoco.mjcf import document, text


@dataclass(frozen=True, eq=False)
class MujocoChain:
    """Links that hang from each other, in the world's frame when all hang straight down.

    lengths  (n,)
    masses   (n,)
    levers   (n,) of the centres of mass, from each link's upper hinge
    moments  (n,) about the centres of mass; of the plane they swing in, the only one they feel
    gravity  downwards

    A link is a body whose three moments are the same, so that no moment is as small as a thin rod's
    about itself. MuJoCo's angles are those between links.
    """

    lengths: Array
    masses: Array
    levers: Array
    moments: Array
    gravity: float
    joint: str = "chain"

    def mjcf(self) -> str:
        """MuJoCo's XML; its numbers are read back bit for bit."""
        bodies = ""
        places = np.append(0.0, self.lengths[:-1])
        links = zip(places, self.masses, self.levers, self.moments, strict=True)
        for place, mass, lever, moment in reversed(list(links)):
            bodies = (
                f'<body pos="{text([0.0, 0.0, -place])}"><joint type="hinge" axis="0 -1 0"/>'
                f'<inertial pos="{text([0.0, 0.0, -lever])}" mass="{text([mass])}" '
                f'diaginertia="{text([moment] * 3)}"/>{bodies}</body>'
            )
        return document([0.0, 0.0, -self.gravity], bodies)


def mujoco_chain(chain: PlanarChain) -> MujocoChain:
    """Bodies with the same motion that MuJoCo accepts.

    It takes no points, which have no moment of inertia. A point between two links belongs to
    either, so each link carries half of the point at its hinge and half of the one at its end, or
    all of the last; at the fixed hinge any mass does.
    """
    m, l = chain.masses, chain.lengths
    if chain.rods:
        return MujocoChain(l, m, 0.5 * l, m * l * l / 12.0, chain.gravity)
    low = np.append(0.5 * m[:-1], m[-1])
    high = np.append(0.5 * m[0], 0.5 * m[:-1])
    whole = low + high
    return MujocoChain(l, whole, low * l / whole, high * low * l * l / whole, chain.gravity)
