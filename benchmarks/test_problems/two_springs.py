"""A point between two springs: a motion of limited smoothness in closed form.

V = k(q) q^2 / 2 with k = 1 for q >= 0 and 4 for q < 0, m = 1, from q = 1 at rest: the force is
Lipschitz continuous with constant 4, its slope jumps at q = 0, and so does q''' at t = pi / 2 and,
at the end of the half revolution that it has to q = 0 again, at t = pi. q has three derivatives in
L^2 and not four.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import Canonical, Problem
from galvi.arrays import Array

SOFT, STIFF = 1.0, 4.0
SMOOTHNESS = 3  # derivatives in L^2
KINK = np.pi / 2.0
DURATION = np.pi  # the second crossing


def _stiffness(q: Array) -> Any:
    return np.where(q >= 0.0, SOFT, STIFF)


def _potential(q: Array) -> float:
    return float(0.5 * _stiffness(q)[0] * q[0] ** 2)


def _gradient(q: Array) -> Array:
    slope: Array = _stiffness(q) * q
    return slope


def _hessian(q: Array) -> Array:
    return np.array([[float(_stiffness(q)[0])]])


def two_springs() -> Problem:
    """The point between two springs, from q = 1 at rest."""
    return Problem(
        Canonical(1.0, _potential, _gradient, _hessian), np.ones(1), np.zeros(1), name="two springs"
    )


def motion(t: Array) -> tuple[Array, Array]:
    """Exact q and q' at times t in [0, pi], of t's shape."""
    late = 2.0 * (t - KINK)
    before = t <= KINK
    q: Array = np.where(before, np.cos(t), -0.5 * np.sin(late))
    v: Array = np.where(before, -np.sin(t), -np.cos(late))
    return q, v
