"""The outer solar system of Applegate et al., with a published energy."""

from __future__ import annotations

import numpy as np

from galvi.problem import Problem
from galvi.systems.nbody import NBody

DAYS = 365.0  # days in the unit of time of this problem
GAUSS = 0.01720209895  # Gaussian gravitational constant, au^(3/2) / (day Msun^(1/2))
BODIES = {  # body: mass (Msun), position (au), velocity (au / day)
    "Sun and inner planets": (
        1.00000597682,
        (-4.06428567034226e-3, -6.08813756435987e-3, -1.66162304225834e-6),
        (+6.69048890636161e-6, -6.33922479583593e-6, -3.13202145590767e-9),
    ),
    "Jupiter": (
        1.0 / 1047.355,
        (+3.40546614227466e0, +3.62978190075864e0, +3.42386261766577e-2),
        (-5.59797969310664e-3, +5.51815399480116e-3, -2.66711392865591e-6),
    ),
    "Saturn": (
        1.0 / 3501.6,
        (+6.60801554403466e0, +6.38084674585064e0, -1.36145963724542e-1),
        (-4.17354020307064e-3, +3.99723751748116e-3, +1.67206320571441e-5),
    ),
    "Uranus": (
        1.0 / 22869.0,
        (+1.11636331405597e1, +1.60373479057256e1, +3.61783279369958e-1),
        (-3.25884806151064e-3, +2.06438412905916e-3, -2.17699042180559e-5),
    ),
    "Neptune": (
        1.0 / 19314.0,
        (-3.01777243405203e1, +1.91155314998064e0, -1.53887595621042e-1),
        (-2.17471785045538e-4, -3.11361111025884e-3, +3.58344705491441e-5),
    ),
    "Pluto": (
        7.4074074e-09,
        (-2.13858977531573e1, +3.20719104739886e1, +2.49245689556096e0),
        (-1.76936577252484e-3, -2.06720938381724e-3, +6.58091931493844e-4),
    ),
}


def applegate() -> Problem:
    """Five planets about the Sun, to whose mass those of the inner planets are added.

    Masses and initial state of heyoka.py's notebook "Brouwer's law in the outer Solar System", from
    Applegate, Douglas, Gursel, Sussman and Wisdom, Astron. J. 92 (1986) 176. REBOUND's example of
    the same name uses them with a massless Pluto, so the barycentre is at rest except for Pluto's
    mass. In au, solar masses and years of 365 days the energy is -0.004286848855986956, the value
    printed in heyoka.py's notebook "Conserving first integrals via manifold projection".
    """
    masses, q0, v0 = (np.array(column) for column in zip(*BODIES.values(), strict=True))
    return Problem(
        system=NBody(masses=masses, G=GAUSS * GAUSS * DAYS * DAYS),
        q0=q0,
        v0=v0 * DAYS,
        name="outer solar system after Applegate",
        parameters={"bodies": tuple(BODIES), "source": "Applegate et al. 1986, JPL Horizons"},
        units="au, year of 365 days, solar mass",
    )
