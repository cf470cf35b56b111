"""The harmonic oscillator of H 2.4.1 and M 6.1."""

from __future__ import annotations

import numpy as np

from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.potentials.linear_spring import LinearSpring


def harmonic_oscillator() -> Problem:
    """L = (v^2 - q^2) / 2 from q = 1, v = 0 (H 2.4.1, M 6.1). No units."""
    return Problem(
        system=Canonical(mass=1.0, potential=LinearSpring(1.0)),
        q0=np.array([1.0]),
        v0=np.array([0.0]),
        name="harmonic oscillator",
        units="none (m = k = 1)",
    )
