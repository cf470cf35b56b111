"""Sines, cosines and angles of decimals, and the context that closed forms are computed in.

With 80 digits, what inputs of 16 digits lose where periods grow without bound, and what reducing
an angle after 1e12 turns loses, leaves far more than a result rounded to 16 digits needs. Call
inside ``localcontext(DIGITS)``.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal

DIGITS = Context(prec=80)
SMALLEST = Decimal(10) ** -84  # terms below it are left out of a series
PI = Decimal(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534"
    "2117067982148086513282306647093844609550582231725"
)
TERMS = 60


def sine_cosine(x: Decimal) -> tuple[Decimal, Decimal]:
    """sin x and cos x for any x, by Taylor series within an eighth of a turn."""
    quarters = int((2 * x / PI).to_integral_value())
    r = x - quarters * PI / 2
    sine, cosine, term = Decimal(0), Decimal(0), Decimal(1)
    for k in range(TERMS):
        cosine += term
        term *= r / (2 * k + 1)
        sine += term
        term *= -r / (2 * k + 2)
        if abs(term) < SMALLEST:
            break
    turned = ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))
    return turned[quarters % 4]


def angle(y: Decimal, x: Decimal) -> Decimal:
    """The polar angle of the point (x, y), in (-pi, pi]; 0 at the origin.

    The float64 angle, corrected by the arc tangent of what is left, which is below 1e-15.
    """
    size = max(abs(x), abs(y))
    if not size:
        return Decimal(0)
    near = Decimal(math.atan2(float(y / size), float(x / size)))
    sine, cosine = sine_cosine(near)
    left = (y * cosine - x * sine) / (x * cosine + y * sine)
    series, square = Decimal(0), left * left
    for k in range(4, -1, -1):
        series = Decimal(1) / (2 * k + 1) - square * series
    return near + left * series
