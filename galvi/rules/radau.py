"""Gauss-Radau quadrature."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from galvi import input_checks
from galvi.extended_precision import decimals, extended_precision
from galvi.rules.rule import Rule, from_interval, number_of_points
from galvi.spaces.legendre import legendre


def radau(points: int, left: bool = False) -> Rule:
    """The rule with one end point and degree 2 points - 2; its nodes are those of Radau IIA.

    left  whether the end point is 0 (as in Radau I and IA) instead of 1

    The nodes are mirrored zeros of P_{n-1} + P_n, n = points. Raises ValueError unless points is a
    whole number from 1 to 1000.
    """
    input_checks.flag("left", left)
    return _radau(number_of_points(points), bool(left))


@lru_cache(maxsize=256)
def _radau(n: int, left: bool) -> Rule:
    from scipy.special import roots_jacobi

    with extended_precision():
        x = decimals(roots_jacobi(n - 1, 0.0, 1.0)[0] if n > 1 else [])
        for _ in range(3):  # Newton on (P_{n-1} + P_n) / (1 + x): 16, 32, 64 digits
            P = legendre(x, n)
            value, slope = P[:, n - 1] + P[:, n], n * (P[:, n - 1] - P[:, n]) / (1 - x)
            x = x - value / (slope - value / (1 + x))
        x = np.concatenate([decimals([-1.0]), x])
        weights = (1 - x) / (n * legendre(x, n)[:, n - 1]) ** 2
        name = f"Radau {n}, from the left" if left else f"Radau {n}"
        if not left:
            x, weights = -x[::-1], weights[::-1]
        return from_interval(name, 2 * n - 2, x, weights)
