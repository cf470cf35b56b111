"""Fermi, Pasta, Ulam and Tsingou's chain of soft and stiff springs in turn.

Hairer, Lubich and Wanner, Geometric Numerical Integration, I.5.1: masses 2 m, x_(0,i) and x_(1,i)
the scaled place and stretch of the i-th stiff spring,

    H = |y|^2 / 2 + omega^2 / 2 sum x_(1,i)^2 + 1/4 [ (x_(0,1) - x_(1,1))^4 + (x_(0,m) + x_(1,m))^4
        + sum (x_(0,i+1) - x_(1,i+1) - x_(0,i) - x_(1,i))^4 ]

The stiff springs exchange energy in times of order omega, while the sum of their energies changes
by O(1 / omega).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi import Canonical, Problem
from galvi.arrays import Array

SPRINGS = 3


def stiff_springs(omega: float = 50.0) -> Problem:
    """Three stiff springs; x_(0,1) = 1 and x_(1,1) = 1 / omega at the start, y = 1 for both."""
    n = SPRINGS

    def gaps(q: Any) -> list[Any]:
        inner = [q[i + 1] - q[n + i + 1] - q[i] - q[n + i] for i in range(n - 1)]
        return [q[0] - q[n], *inner, q[n - 1] + q[2 * n - 1]]

    def potential(q: Any) -> Any:
        stiff = sum(q[n + i] ** 2 for i in range(n))
        return 0.5 * omega**2 * stiff + 0.25 * sum(gap**4 for gap in gaps(q))

    def gradient(q: Any) -> Any:
        cubes = [gap**3 for gap in gaps(q)]
        places = [cubes[i] - cubes[i + 1] for i in range(n - 1)] + [cubes[n - 1] + cubes[n]]
        stretches = [
            omega**2 * q[n + i] - cubes[i] + (cubes[n] if i == n - 1 else -cubes[i + 1])
            for i in range(n)
        ]
        return np.array(places + stretches)

    q0, v0 = np.zeros((2, 2 * n))
    q0[0], q0[n], v0[0], v0[n] = 1.0, 1.0 / omega, 1.0, 1.0
    return Problem(
        Canonical(1.0, potential, gradient), q0, v0, name="soft and stiff springs",
        parameters={"omega": omega}, units="none",
    )  # fmt: skip


def stiffness(omega: float = 50.0) -> Array:
    """(2 m, 2 m) of the stiff springs."""
    return np.diag([0.0] * SPRINGS + [omega**2] * SPRINGS)


def oscillatory_energies(q: Array, v: Array, omega: float = 50.0) -> Array:
    """I_1 to I_m of states (k, 2 m), (k, m)."""
    energies: Array = 0.5 * v[:, SPRINGS:] ** 2 + 0.5 * omega**2 * q[:, SPRINGS:] ** 2
    return energies
