"""Gauss-Lobatto quadrature."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from galvi.extended_precision import decimals, extended_precision
from galvi.rules.rule import Rule, from_interval, number_of_points
from galvi.spaces.legendre import legendre


def lobatto(points: int) -> Rule:
    """The rule with both end points and degree 2 points - 3; with two points, trapezoidal.

    The inner nodes are the zeros of P_n', n = points - 1. Raises ValueError unless points is a
    whole number from 2 to 1000.
    """
    return _lobatto(number_of_points(points, at_least=2))


@lru_cache(maxsize=256)
def _lobatto(points: int) -> Rule:
    from scipy.special import roots_jacobi

    n = points - 1
    with extended_precision():
        x = decimals(roots_jacobi(n - 1, 1.0, 1.0)[0] if n > 1 else [])
        for _ in range(3):  # Newton on P_n', with P_n'' from Legendre's equation
            P = legendre(x, n)
            slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
            curvature = (2 * x * slope - n * (n + 1) * P[:, n]) / (1 - x * x)
            x = x - slope / curvature
        x = np.concatenate([decimals([-1.0]), x, decimals([1.0])])
        weights = 2 / (n * (n + 1) * legendre(x, n)[:, n] ** 2)
        return from_interval(f"Lobatto {points}", 2 * points - 3, x, weights)
