"""Arithmetic with 60 decimal digits for tables, so that stored numbers are rounded only once.

An error in a table acts on every step with the same sign, as a drift of the energy (Hairer,
McLachlan, Razakarivony, BIT 48 (2008) 231, section 2). Arrays of dtype object hold the decimals.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only

DIGITS = 60
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")


@contextmanager
def extended_precision() -> Iterator[None]:
    """A context in which decimals are computed with ``DIGITS`` digits."""
    with localcontext(Context(prec=DIGITS)):
        yield


def decimals(numbers: Any) -> Any:
    """The numbers as an object array of decimals, each converted exactly."""
    numbers = np.asarray(numbers)
    exact = [x if isinstance(x, Decimal) else Decimal(float(x)) for x in numbers.ravel()]
    out = np.empty(numbers.size, dtype=object)
    out[:] = exact
    return out.reshape(numbers.shape)


def rounded(numbers: Any) -> Array:
    """The nearest float64 numbers, read-only."""
    return read_only(np.array(numbers, dtype=np.float64))


def scaled(numbers: Array, by: float, power: int = 1) -> Array:
    """Numbers times by**power; argument and result are float64 numbers and their low parts, (2,
    ...).

    The relative error is at most 2^-98. Dekker's exact product (Numer. Math. 18 (1971) 224) is used
    instead of decimals, since this is done for each step size, and on mantissas, so that no
    intermediate number overflows.
    """
    mantissa, exponent = math.frexp(by)
    high, low = numbers
    for _ in range(power):
        product = high * mantissa
        (x, x_low), (y, y_low) = _halves(high), _halves(np.float64(mantissa))
        error = x_low * y_low - (((product - x * y) - x_low * y) - x * y_low)
        error = error + low * mantissa
        high = product + error
        low = error - (high - product)
    with np.errstate(all="ignore"):  # the result itself may overflow
        return np.ldexp(np.stack([high, low]), power * exponent)


def _halves(numbers: Any) -> tuple[Any, Any]:
    """Two parts of at most 26 bits each."""
    multiple = (2.0**27 + 1.0) * numbers
    upper = multiple - (multiple - numbers)
    return upper, numbers - upper


def cosine(angle: Decimal) -> Decimal:
    """cos(angle) by its Taylor series, for angles up to pi."""
    total, term, k = Decimal(0), Decimal(1), 0
    while abs(term) > Decimal(10) ** -(DIGITS + 5):
        total += term
        k += 2
        term *= -angle * angle / (k * (k - 1))
    return total


def circle(angle: Decimal) -> tuple[Decimal, Decimal]:
    """cos(angle) and sin(angle), for any angle."""
    reduced = angle - 2 * PI * (angle / (2 * PI)).to_integral_value()
    return cosine(reduced), cosine(reduced - PI / 2)
