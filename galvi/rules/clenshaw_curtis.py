"""Clenshaw-Curtis quadrature."""

from __future__ import annotations

from decimal import Decimal
from functools import lru_cache

import numpy as np

from galvi.extended_precision import PI, cosine, decimals, extended_precision
from galvi.rules.rule import Rule, from_interval, number_of_points


def clenshaw_curtis(points: int) -> Rule:
    """The interpolatory rule on the Chebyshev points cos(j pi / (points - 1)).

    Its degree is points - 1, one more for an odd number of points; with one point, the midpoint
    rule.
    Raises ValueError unless points is a whole number from 1 to 1000.
    """
    return _clenshaw_curtis(number_of_points(points))


@lru_cache(maxsize=256)
def _clenshaw_curtis(points: int) -> Rule:
    n = points - 1
    name = f"Clenshaw-Curtis {points}"
    with extended_precision():
        if n == 0:
            return from_interval(name, 1, decimals([0.0]), decimals([2.0]))
        cosines = decimals([float(n)] * (n + 1))
        for j in range(n + 1):  # cos(j pi / n), mirrored so that the rule is symmetric to the bit
            k = min(j, n - j)
            value = cosine(PI * k / n) if 2 * k != n else Decimal(0)
            cosines[j] = value if j == k else -value
        terms = np.arange(1, n // 2 + 1)
        share = decimals(np.where(2 * terms == n, 1.0, 2.0)) / (4 * terms * terms - 1)
        turn = np.outer(np.arange(n + 1), 2 * terms) % (2 * n)
        weights = (1 - cosines[np.where(turn > n, 2 * n - turn, turn)] @ share) * 2 / n
        weights[[0, -1]] /= 2
        degree = n + 1 if n % 2 == 0 else n
        return from_interval(name, degree, -cosines, weights)
