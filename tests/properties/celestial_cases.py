"""Point masses with each of the celestial forces."""

from __future__ import annotations

import numba
import numpy as np

import galvi

MASSES = [1.0, 1e-3, 2e-4]
Q = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [-0.3, 2.1, 0.1]])
V = np.array([[0.0, 0.0, 0.0], [0.1, 0.95, 0.1], [-0.65, -0.1, 0.05]])


@numba.njit
def towards_the_plane(q):
    """A spring that pulls the second body towards the plane x = 0."""
    force = np.zeros_like(q)
    force[1, 0] = -1e-4 * q[1, 0]
    return force


@numba.njit
def stronger_with_time(q, v, t):
    """Drag of the second body, which grows with the time."""
    force = np.zeros_like(q)
    force[1] = -1e-5 * v[1] * (1.0 + t)
    return force


def drag_in_python(q, v):
    """Drag of all bodies."""
    return -1e-5 * v


WITH_ENERGY = {
    "J2 and J4": (galvi.Oblateness(0, 1e-3, 0.3, J4=-1e-3, pole=(0.3, 0.1, 1)),),
    "J2 of a planet": (galvi.Oblateness(1, 1e-2, 0.3), galvi.Oblateness(0, 1e-3, 0.3)),
    "potential": (galvi.Relativity(30.0, form="potential"),),
    "power laws": (galvi.PowerLaw(1, -1e-2, 0.5), galvi.PowerLaw(0, 1e-2, -1)),
}
OF_VELOCITY = {
    "one source": (galvi.Relativity(30.0),),
    "EIH": (galvi.Relativity(30.0, form="EIH"),),
    "radiation": (galvi.Radiation([0, 0.01, 0.02], c=100.0),),
    "drag": (galvi.Drag([0, 0.001, 0.002], 2.0),),
    "tides": (
        galvi.Tides(0, 0.3, 0.3, 0.01, spin=(0.1, 0.2, 3)),
        galvi.Tides(1, 0.3, 0.1, 0.01, raised_by=0),
    ),
    "a function of time": (
        galvi.Force(stronger_with_time, True, True),
        galvi.Oblateness(0, 1e-3, 0.3),
    ),
    "Python": (galvi.Force(drag_in_python, True), galvi.Drag([0, 0.001, 0.002])),
}
FUNCTION_OF_POSITION = {
    "a function": (galvi.Force(towards_the_plane), galvi.Oblateness(0, 1e-3, 0.3))
}
CASES = {**WITH_ENERGY, **OF_VELOCITY, **FUNCTION_OF_POSITION}
FORCE_PAIRS = [  # cases whose forces keep the total momentum, up to rounding
    name
    for name in CASES
    if name
    not in (
        "radiation",
        "drag",
        "a function of time",
        "Python",
        "a function",
        "EIH",
    )
]


def bodies(forces, masses=MASSES, plane: bool = False) -> galvi.Problem:
    """Three bodies with ``forces`` and a total momentum of 0, in the plane if ``plane``."""
    system = galvi.NBody(masses, forces=forces)
    v = V - system.masses @ V / np.sum(system.masses)
    size = 2 if plane else 3
    return galvi.Problem(system, Q[:, :size], v[:, :size])


def eccentric(force):
    """Two bodies on an orbit of e = 0.6, a = 1, from its pericentre."""
    masses = np.array([1.0, 1e-3])
    # The positions and velocities of both, as fractions of the relative ones.
    fractions = np.array([[-1e-3], [1.0]]) / 1.001
    speed = np.sqrt(1.001 * 1.6 / 0.4)
    return galvi.Problem(
        galvi.NBody(masses, forces=force),
        fractions * [[0.4, 0.0, 0.0]],
        fractions * [[0.0, speed, 0.0]],
    )
