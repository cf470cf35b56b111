"""The action of the two-body motion between two points in a given time, by Lambert's theorem.

With c = |r1 - r0|, s = (|r0| + |r1| + c) / 2 and sin^2(alpha/2) = s / (2 a), sin^2(beta/2) =
(s - c) / (2 a), the time is sqrt(a^3 / gm) ((alpha - sin alpha) - (beta - sin beta)), and
alpha - beta the eccentric anomaly covered (Battin, Astrodynamics (1999), chapters 6 and 7). Since
L = v^2/2 + gm/r = 2 gm/r - gm/(2 a) and dt/r = sqrt(a/gm) dE,
  S = integral of L dt = 2 sqrt(gm a) (alpha - beta) - gm h / (2 a).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal, localcontext

from references.closed_forms.double_double import DIGITS, angle, sine_cosine

BISECTIONS = 60  # of the start in double precision
CORRECTIONS = 8  # largest number of Newton steps in decimals
TIME_TOLERANCE = Decimal("1e-30")  # relative error of the time at which the iteration ends


def kepler_action(gm: float, start: Sequence[float], end: Sequence[float], h: float) -> float:
    """Integral of |v|^2/2 + gm/|r| over the arc of an ellipse from `start` to `end` (d,) in the
    time h > 0, by less than half a turn about the centre; NaN where that arc is not elliptic.

    The arguments are taken as exact; the result is rounded once.
    """
    with localcontext(DIGITS):
        mu, time = Decimal(gm), Decimal(h)
        first, last = ([Decimal(float(x)) for x in vector] for vector in (start, end))
        chord = _length([b - a for a, b in zip(first, last, strict=True)])
        s = (_length(first) + _length(last) + chord) / 2
        ratio = ((s - chord) / s).sqrt()
        unit = (s**3 / (8 * mu)).sqrt()  # of the time, that of the axis a = s / 2
        x = _start(float(ratio), float(time / unit))
        if x is None:
            return math.nan
        for _ in range(CORRECTIONS):
            alpha, beta, axis = _angles(x, ratio)
            gap = axis * axis.sqrt() * (_excess(alpha) - _excess(beta)) - time / unit
            if abs(gap) <= TIME_TOLERANCE * time / unit:
                a = axis * s / 2
                return float(2 * (mu * a).sqrt() * (alpha - beta) - mu * time / (2 * a))
            x -= gap / _slope(x, ratio, time / unit + gap)
    return math.nan


def _start(ratio: float, time: float) -> Decimal | None:
    """x = cos(alpha/2) in double precision, by bisection; the time falls as x grows from -1 to 1.

    None where the arc is not elliptic.
    """
    low, high = -1.0 + 1e-12, 1.0 - 1e-12
    for _ in range(BISECTIONS):
        x = 0.5 * (low + high)
        alpha, beta = 2.0 * math.acos(x), 2.0 * math.asin(ratio * math.sqrt(1.0 - x * x))
        flight_time = (alpha - math.sin(alpha) - beta + math.sin(beta)) / (1.0 - x * x) ** 1.5
        low, high = (x, high) if flight_time > time else (low, x)
    return None if min(1.0 - high, 1.0 + low) < 1e-9 else Decimal(x)


def _angles(x: Decimal, ratio: Decimal) -> tuple[Decimal, Decimal, Decimal]:
    """alpha, beta and 2 a / s for x = cos(alpha/2)."""
    sine = (1 - x * x).sqrt()
    half_beta_sine = ratio * sine
    return (
        2 * angle(sine, x),
        2 * angle(half_beta_sine, (1 - half_beta_sine * half_beta_sine).sqrt()),
        1 / (1 - x * x),
    )


def _excess(x: Decimal) -> Decimal:
    return x - sine_cosine(x)[0]


def _slope(x: Decimal, ratio: Decimal, time: Decimal) -> Decimal:
    """d time / dx: (1 - x^2) T' = 3 T x - 4 + 4 ratio^3 x / sqrt(1 - ratio^2 (1 - x^2))."""
    y = (1 - ratio * ratio * (1 - x * x)).sqrt()
    return (3 * time * x - 4 + 4 * ratio**3 * x / y) / (1 - x * x)


def _length(vector: list[Decimal]) -> Decimal:
    return sum((x * x for x in vector), Decimal(0)).sqrt()
