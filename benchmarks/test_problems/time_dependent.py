"""Oscillators whose mass or potential depends on time, with their motions in closed form.

L = mu(t) u'^2 / 2 - V(t, u) as in M section 2:

    growing mass  mu = e^(g t), V = w^2 e^(g t) u^2 / 2:  u = e^(-g t / 2) cos(W t),
                  W^2 = w^2 - g^2 / 4
    driven        mu = 1, V = u^2 / 2 - u cos 2 t:  u = (4/3) cos t + (1/2) sin t - (1/3) cos 2 t
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from galvi import Problem
from galvi.arrays import Array

GROWTH, FREQUENCY = 0.5, 1.3  # g, w
TURNING = math.sqrt(FREQUENCY**2 - GROWTH**2 / 4.0)  # W


@dataclass(frozen=True, eq=False)
class TimedOscillator:
    """mass, slope  mu of t, and V' of (t, u), of their shape
    motion       t -> (u, u')
    system       for galvi
    where        in words
    """

    name: str
    mass: Callable[[Array], Array]
    slope: Callable[[Array, Array], Array]
    motion: Callable[[Array], tuple[Array, Array]]
    system: Any
    where: str

    def problem(self, t: float = 0.0) -> Problem:
        """The problem from the exact state at t on."""
        u, v = self.motion(np.array([t]))
        return Problem(self.system, u, v, t, name=self.name)


def _growing(q: Array, v: Array, t: float) -> Any:
    return 0.5 * np.exp(GROWTH * t) * (v[0] ** 2 - FREQUENCY**2 * q[0] ** 2)


def _damped(t: Array) -> tuple[Array, Array]:
    size = np.exp(-0.5 * GROWTH * t)
    u = size * np.cos(TURNING * t)
    return u, -0.5 * GROWTH * u - TURNING * size * np.sin(TURNING * t)


def _potential(q: Array, t: float) -> Any:
    return 0.5 * q[0] ** 2 - q[0] * np.cos(2.0 * t)


def _gradient(q: Array, t: float) -> Array:
    return np.array([q[0] - np.cos(2.0 * t)])


def _forced(t: Array) -> tuple[Array, Array]:
    u = 4.0 * np.cos(t) / 3.0 + 0.5 * np.sin(t) - np.cos(2.0 * t) / 3.0
    return u, -4.0 * np.sin(t) / 3.0 + 0.5 * np.cos(t) + 2.0 * np.sin(2.0 * t) / 3.0


GROWING_MASS = TimedOscillator(
    "growing mass",
    lambda t: np.exp(GROWTH * t),
    lambda t, u: FREQUENCY**2 * np.exp(GROWTH * t) * u,
    _damped,
    galvi.Lagrangian(_growing, galvi.Rn(1), explicit_time=True),
    f"mu = e^({GROWTH:g} t), V = {FREQUENCY:g}^2 e^({GROWTH:g} t) u^2 / 2, u0 = 1, "
    f"u'(0) = {-GROWTH / 2.0:g}",
)
DRIVEN = TimedOscillator(
    "driven potential",
    np.ones_like,
    lambda t, u: u - np.cos(2.0 * t),
    _forced,
    galvi.Canonical(1.0, _potential, _gradient, explicit_time=True),
    "mu = 1, V = u^2 / 2 - u cos 2 t, u0 = 1, u'(0) = 1/2",
)
TIMED = (GROWING_MASS, DRIVEN)
