"""Gauss-Legendre quadrature."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from galvi.extended_precision import decimals, extended_precision
from galvi.rules.rule import Rule, from_interval, number_of_points
from galvi.spaces.legendre import legendre


def gauss(points: int) -> Rule:
    """The rule with the highest degree of exactness, 2 points - 1; its nodes are the zeros of P_n.

    Raises ValueError unless points is a whole number from 1 to 1000.
    """
    return _gauss(number_of_points(points))


@lru_cache(maxsize=256)
def _gauss(n: int) -> Rule:
    with extended_precision():
        x = decimals(np.polynomial.legendre.leggauss(n)[0])
        for _ in range(3):  # Newton: 16, 32, 64 digits
            P = legendre(x, n)
            slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
            x = x - P[:, n] / slope
        P = legendre(x, n)
        slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
        return from_interval(f"Gauss {n}", 2 * n - 1, x, 2 / ((1 - x * x) * slope * slope))
