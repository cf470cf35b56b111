"""Nonlinear oscillators of mass 1 with the Lipschitz constant of their force, for contractions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import galvi
from galvi import Problem
from galvi.arrays import Array

SAMPLES = 200  # of curves in the region


@dataclass(frozen=True, eq=False)
class NonlinearOscillator:
    """q'' = -V'(q) from (q, v) at t = 0.

    slope      V', and its derivative `curvature`, of any shape
    radius     of the interval |q| <= radius where V' is Lipschitz continuous; inf for the line
    lipschitz  K, the largest |V''| there
    where      that interval and K in words
    """

    name: str
    problem: Callable[[], Problem]
    slope: Callable[[Array], Array]
    curvature: Callable[[Array], Array]
    radius: float
    lipschitz: float
    where: str

    def places(self, size: int) -> Array:
        """Places in the interval, (samples, size): random ones, and those where |V''| is K."""
        far = min(self.radius, math.pi)
        found = np.random.default_rng(0).uniform(-far, far, (SAMPLES, size))
        steepest = 0.0 if math.isinf(self.radius) else self.radius
        return np.vstack([found, np.full((1, size), steepest)])


RADIUS = 1.5
PENDULUM = NonlinearOscillator(
    "pendulum",
    lambda: Problem(galvi.Canonical(1.0, galvi.CosinePotential(1.0)), np.ones(1), np.ones(1)),
    np.sin,
    np.cos,
    math.inf,
    1.0,
    "V = -cos q, from q = v = 1: K = 1 on the whole line, as the theorem asks",
)
HARDENING = NonlinearOscillator(
    "hardening spring",
    lambda: Problem(galvi.Canonical(1.0, _quartic, _cubic), np.ones(1), np.full(1, 0.5)),
    lambda q: q + q**3,
    lambda q: 1.0 + 3.0 * q**2,
    RADIUS,
    1.0 + 3.0 * RADIUS**2,
    f"V = q^2 / 2 + q^4 / 4, from q = 1, v = 0.5: K = 1 + 3 rho^2 on |q| <= rho = {RADIUS:g}, "
    "where the iterates stay",
)
NONLINEAR = (PENDULUM, HARDENING)


def _quartic(q: Array) -> float:
    return float(0.5 * q[0] ** 2 + 0.25 * q[0] ** 4)


def _cubic(q: Array) -> Array:
    with np.errstate(over="ignore"):  # passes above the bound diverge
        return np.asarray(q + q**3)
