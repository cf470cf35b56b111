"""Numbers of two doubles, and trigonometry in decimals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Context, Decimal
from typing import Any

from galvi.arrays import Array

# Sines, cosines and angles of decimals, and the context in which closed forms are computed.
#
# 80 digits leave far more than 16 correct ones, even near a separatrix, where periods grow without
# bound, and after reducing an angle of 1e12 turns. Call inside ``localcontext(DIGITS)``.

DIGITS = Context(prec=80)
SMALLEST = Decimal(10) ** -84  # a series ends at the first term below it
PI = Decimal(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534"
    "2117067982148086513282306647093844609550582231725"
)
TERMS = 60  # largest number of pairs of terms of a series
SPLITTER = 134217729.0  # 2^27 + 1, halves a 53-bit significand


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

    The float64 angle is corrected by the arc tangent series of the remaining angle, which is below
    1e-15.
    """
    size = max(abs(x), abs(y))
    if not size:
        return Decimal(0)
    estimate = Decimal(math.atan2(float(y / size), float(x / size)))
    sine, cosine = sine_cosine(estimate)
    tangent = (y * cosine - x * sine) / (x * cosine + y * sine)
    series, square = Decimal(0), tangent * tangent
    for k in range(4, -1, -1):
        series = Decimal(1) / (2 * k + 1) - square * series
    return estimate + tangent * series


# Numbers of twice the double precision, as unevaluated sums hi + lo of two float64 arrays.
#
# Relative errors are a few 2^-104. Sums after Knuth, products after Dekker (Numer. Math. 18 (1971)
# 224); no fused operation and no wider type of the machine is used. Products beyond 1e292 overflow.


@dataclass(frozen=True, eq=False)
class DoubleDouble:
    """hi + lo with |lo| at most half a unit in the last place of hi; shapes broadcast.

    The other operand may be a float or a float64 array, which is taken as exact.
    """

    hi: Any
    lo: Any = 0.0
    __array_ufunc__ = None  # numpy leaves array + DoubleDouble to this class

    @staticmethod
    def nearest(number: Decimal) -> DoubleDouble:
        """A scalar from a Decimal of any length."""
        hi = float(number)
        return DoubleDouble(hi, float(number - Decimal(hi)))

    def __getitem__(self, key: Any) -> DoubleDouble:
        return DoubleDouble(self.hi[key], self.lo[key])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.hi, -self.lo)

    def __add__(self, other: DoubleDouble | Array | float) -> DoubleDouble:
        right = _lifted(other)
        hi, error = _sum(self.hi, right.hi)
        lo, lo_error = _sum(self.lo, right.lo)
        hi, error = _ordered_sum(hi, error + lo)
        return DoubleDouble(*_ordered_sum(hi, error + lo_error))

    def __sub__(self, other: DoubleDouble | Array | float) -> DoubleDouble:
        return self + (-_lifted(other))

    def __rsub__(self, other: Array | float) -> DoubleDouble:
        return (-self) + other

    def __mul__(self, other: DoubleDouble | Array | float) -> DoubleDouble:
        right = _lifted(other)
        hi, error = _product(self.hi, right.hi)
        return DoubleDouble(*_ordered_sum(hi, error + (self.hi * right.lo + self.lo * right.hi)))

    def __truediv__(self, other: DoubleDouble | Array | float) -> DoubleDouble:
        right = _lifted(other)
        first = self.hi / right.hi
        remainder = self - right * first
        second = remainder.hi / right.hi
        remainder = remainder - right * second
        return DoubleDouble(*_ordered_sum(first, second)) + remainder.hi / right.hi

    __radd__ = __add__
    __rmul__ = __mul__


def _lifted(number: DoubleDouble | Array | float) -> DoubleDouble:
    return number if isinstance(number, DoubleDouble) else DoubleDouble(number)


def _sum(a: Any, b: Any) -> tuple[Any, Any]:
    """a + b rounded, and its exact rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _ordered_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """As `_sum`, for |a| >= |b| or a = 0."""
    total = a + b
    return total, b - (total - a)


def _product(a: Any, b: Any) -> tuple[Any, Any]:
    """a b rounded, and its exact rounding error."""
    total = a * b
    a1, b1 = SPLITTER * a, SPLITTER * b
    a1, b1 = a1 - (a1 - a), b1 - (b1 - b)
    a2, b2 = a - a1, b - b1
    return total, ((a1 * b1 - total) + a1 * b2 + a2 * b1) + a2 * b2
