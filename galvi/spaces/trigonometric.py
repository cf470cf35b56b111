"""Cosines and sines as Legendre series, split into their polynomial part and the rest.

With W = k w and x = 2 t - 1, the derivatives of cos W (t - 1/2) and sin W (t - 1/2) are
proportional to sin(W x / 2) and cos(W x / 2), whose coefficients of P_l(x) are
(2 l + 1) (-1)^(l // 2) j_l(W / 2), for odd l and for even l (j_l the spherical Bessel functions;
DLMF 10.60.7). Omitting all terms with l < s projects onto the complement of the polynomials without
cancellation.
"""

from __future__ import annotations

from decimal import Context, Decimal, localcontext
from functools import lru_cache
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, rounded
from galvi.spaces.legendre import integrals, legendre

DIGITS = 100  # digits of the series; tables use 60
SMALL = Decimal("1e-90")  # relative size of the last coefficient kept
TELLING = Decimal("1e-25")  # least part of a wave outside polynomials and slower waves
MOST = 64  # largest number of harmonics
FASTEST = 512.0  # radians a step, some 80 periods


def wave_numbers(harmonics: Any, frequency: Any) -> tuple[int, float]:
    """Both values; ValueError unless 1 to 64 harmonics, the fastest at most 512 radians a step."""
    count = input_checks.whole("harmonics", harmonics, 1, MOST)
    w = input_checks.positive("frequency", frequency, "Give it in radians a step, such as 2 pi.")
    if count * w > FASTEST:
        raise ValueError(
            f"harmonics times frequency must be at most {FASTEST:g} radians a step; received "
            f"{count} times {w:g}. Use a shorter step or fewer harmonics."
        )
    return count, w


def waves(t: Any, skip: int, harmonics: int, frequency: float) -> Any:
    """The integrals over [0, t] of `wave_derivatives`, (k, 2 harmonics), t of shape (k,)."""
    slopes = wave_slopes(skip, harmonics, frequency)[0 if t.dtype == object else 1]
    return integrals(t, skip + len(slopes))[:, skip:] @ slopes


def wave_derivatives(t: Any, skip: int, harmonics: int, frequency: float) -> Any:
    """The functions of `wave_slopes` at t of shape (k,), as (k, 2 harmonics)."""
    slopes = wave_slopes(skip, harmonics, frequency)[0 if t.dtype == object else 1]
    return legendre(2 * t - 1, skip + len(slopes) - 1)[:, skip:] @ slopes


@lru_cache(maxsize=64)
def wave_slopes(skip: int, harmonics: int, frequency: float) -> tuple[Any, Array]:
    """Slopes of the waves beyond polynomials, T (l, 2 harmonics), as decimals and as floats.

    sum_l T_li P_{skip + l}(2 t - 1) are orthonormal on [0, 1] and, with P_0 .. P_{skip - 1}, span
    the derivatives of polynomials up to the degree ``skip`` and of cos k w t, sin k w t,
    k = 1 .. harmonics.

    Raises ValueError when a wave is a combination of polynomials and slower waves to 25 digits.
    """
    with localcontext(Context(prec=DIGITS)):
        half = Decimal(frequency) / 2
        length = _terms(skip + 2 * harmonics, harmonics * half)
        degrees = np.arange(length)
        root = np.array([Decimal(int(2 * n + 1)).sqrt() for n in degrees])
        sign = np.where(degrees // 2 % 2 == 0, 1, -1)
        columns: list[Any] = []
        for k in range(1, harmonics + 1):
            series = (root * sign * spherical_bessel(k * half, length))[skip:]
            for parity in (1, 0):
                wave = series * (degrees[skip:] % 2 == parity)
                columns.append(_beyond(columns, wave, skip, frequency))
        slopes = np.stack(columns, axis=-1) * root[skip:, None]
    slopes.setflags(write=False)
    return slopes, rounded(slopes)


def _beyond(columns: list[Any], wave: Any, skip: int, frequency: float) -> Any:
    """The part of the wave orthogonal to the columns, normalised."""
    left = wave / (wave @ wave).sqrt()
    for _ in range(2):
        for column in columns:
            left = left - (column @ left) * column
    size = (left @ left).sqrt()
    if size < TELLING:
        raise ValueError(
            f"cosines and sines of frequency {frequency:g} radians a step must differ from "
            f"polynomials and from each other; {len(columns) + 1} of them on top of degree {skip} "
            f"do not, to 25 digits. Use Polynomials, fewer harmonics or a longer step."
        )
    return left / size


def _terms(least: int, x: Decimal) -> int:
    """Number of terms after which coefficients are below SMALL times that of index ``least``."""
    share, n = Decimal(1), least
    while share > SMALL:  # ends: the factors fall below 1/2
        n += 1
        share *= min(Decimal(1), x / (2 * n + 1))
    return n + 1


def spherical_bessel(x: Decimal, length: int) -> Any:
    """j_0(x) .. j_{length - 1}(x) by j_{l-1} = (2 l + 1) / x j_l - j_{l+1}, downwards.

    Scaled by sum_l (2 l + 1) j_l^2 = 1; positive where l > x (DLMF 10.51.1, 10.60.12).
    """
    values = decimals(np.zeros(length + 2))
    values[length] = Decimal(1)
    for n in range(length, 0, -1):
        values[n - 1] = (2 * n + 1) / x * values[n] - values[n + 1]
    norm = sum((2 * n + 1) * values[n] ** 2 for n in range(length + 1))
    return values[:length] / Decimal(norm).sqrt()
