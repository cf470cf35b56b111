"""Closed Newton-Cotes quadrature."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from functools import lru_cache

import numpy as np

from galvi import input_checks
from galvi.extended_precision import extended_precision
from galvi.rules.rule import Rule

MOST = 8


def newton_cotes(points: int) -> Rule:
    """The interpolatory rule on ``points`` equally spaced nodes, both ends among them, 2 to 8.

    Its degree is points - 1, one more for an odd number of points; two points give the trapezoidal
    rule, three Simpson's. With 9 points, and with 11 or more, some weights are negative.

    Raises ValueError unless points is a whole number from 2 to 8.
    """
    number = input_checks.whole("points", points, 2)
    if number > MOST:
        raise ValueError(
            f"points must be a whole number from 2 to {MOST}, since the closed Newton-Cotes rule "
            f"with 9 points is the first with a negative weight; received {number}. Use gauss, "
            f"lobatto or clenshaw_curtis, or composite(newton_cotes(5), pieces)."
        )
    return _newton_cotes(number)


@lru_cache(maxsize=16)
def _newton_cotes(points: int) -> Rule:
    n = points - 1
    with extended_precision():
        nodes = tuple(Decimal(j) / n for j in range(points))
        weights = tuple(_ratio(_lagrange_integral(j, n)) for j in range(points))
        degree = points if points % 2 else n
        return Rule(f"Newton-Cotes {points}", degree, nodes, weights)


def _lagrange_integral(j: int, n: int) -> Fraction:
    """Integral over x in [0, n], divided by n, of the product of (x - i) / (j - i) over i != j."""
    product = np.array([Fraction(1)])
    for i in range(n + 1):
        if i != j:
            product = np.convolve(product, np.array([Fraction(-i, j - i), Fraction(1, j - i)]))
    total = sum((c * Fraction(n) ** k / (k + 1) for k, c in enumerate(product)), Fraction(0))
    return Fraction(total)


def _ratio(number: Fraction) -> Decimal:
    return Decimal(number.numerator) / Decimal(number.denominator)
