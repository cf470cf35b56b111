"""A driven point whose acceleration has a singularity: a motion of stated finite smoothness.

u'' + k u = |t - t*|^(-b), b < 1/2, m = 1, k = 1 or 0, with u = u' = 0 at t*. With x = t - t*

    u' = sign(x) sum_j a_j |x|^(2 j + 1 - b),   a_j = (-k)^j / ((1 - b) (2 - b) ... (2 j + 1 - b)),
    u  = sum_j a_j |x|^(2 j + 2 - b) / (2 j + 2 - b).

The s-th derivative is like |x|^(2 - s - b) and in L^2 as long as s < 5/2 - b: s = 2 for b from -1/2
(excluded) to 1/2, s = 3 from -3/2 to -1/2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from galvi import Canonical, LinearSpring, Problem
from galvi.arrays import Array

TERMS = 12  # |x| <= 1: the next is below 1e-25


@dataclass(frozen=True)
class SingularDrive:
    """place  t*;  b  the exponent;  spring  whether k is 1."""

    place: float
    b: float
    spring: bool = False

    @property
    def smoothness(self) -> int:
        """s, the number of derivatives in L^2."""
        return math.ceil(2.5 - self.b) - 1

    @property
    def powers(self) -> Array:
        """2 j + 1 - b, (terms,): one without a spring."""
        return np.asarray(2.0 * np.arange(TERMS if self.spring else 1) + 1.0 - self.b)

    @property
    def coefficients(self) -> Array:
        """a_j, (terms,)."""
        products = np.cumprod(np.arange(1, 2 * len(self.powers)) - self.b)[::2]
        return np.asarray((-1.0) ** np.arange(len(products)) / products)

    def motion(self, t: Array) -> tuple[Array, Array]:
        """Exact u and u' at times t, of t's shape."""
        x = np.asarray(t, dtype=np.float64)[..., None] - self.place
        terms = self.coefficients * abs(x) ** self.powers
        u = np.sum(terms * abs(x) / (self.powers + 1.0), axis=-1)
        return u, np.sum(np.sign(x) * terms, axis=-1)

    def problem(self, t: float) -> Problem:
        """The problem from time t on."""

        def drive(q: Array, v: Array, s: float) -> Array:
            return np.full(1, abs(s - self.place) ** -self.b)

        u, v = self.motion(np.array([t]))
        system = Canonical(1.0, LinearSpring(float(self.spring)), force=drive, timed_force=True)
        return Problem(system, u, v, t, name="driven point")
