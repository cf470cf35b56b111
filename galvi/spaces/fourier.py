"""Trigonometric functions on [0, 1], alone or with polynomials.

Cosines and sines are Legendre series, split into their polynomial part and the rest. With W = k w
and x = 2 t - 1, the derivatives of cos W (t - 1/2) and sin W (t - 1/2) are proportional to
sin(W x / 2) and cos(W x / 2), whose coefficients of P_l(x) are (2 l + 1) (-1)^(l // 2) j_l(W / 2),
for odd l and for even l (j_l the spherical Bessel functions; DLMF 10.60.7). Omitting all terms with
l < s projects onto the complement of the polynomials without cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, rounded
from galvi.kernels.constants import TWO_PI
from galvi.spaces.polynomials import MAX_DEGREE, Polynomials, integrals, legendre

SERIES_DIGITS = 100  # digits of the series; tables use 60
SMALLEST_COEFFICIENT = Decimal("1e-90")  # relative size below which a series ends
# Smallest share of a wave that must lie outside the span of polynomials and slower waves.
SMALLEST_REMAINDER = Decimal("1e-25")
MAX_HARMONICS = 64
MAX_FREQUENCY = 512.0  # radians a step, some 80 periods


def wave_numbers(harmonics: Any, frequency: Any) -> tuple[int, float]:
    """Harmonics and frequency as numbers; ValueError unless there are 1 to 64 harmonics, the
    fastest of at most 512 radians a step."""
    count = input_checks.whole("harmonics", harmonics, 1, MAX_HARMONICS)
    w = input_checks.positive("frequency", frequency, "Give it in radians a step, such as 2 pi.")
    if count * w > MAX_FREQUENCY:
        raise ValueError(
            f"harmonics times frequency must be at most {MAX_FREQUENCY:g} radians a step; received "
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

    Raises
    ------
    ValueError
        When a wave is a combination of polynomials and slower waves to 25 digits.
    """
    with localcontext(Context(prec=SERIES_DIGITS)):
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
    """The part of the wave orthogonal to the columns, normalised; ValueError where that is
    zero."""
    left = wave / (wave @ wave).sqrt()
    for _ in range(2):
        for column in columns:
            left = left - (column @ left) * column
    size = (left @ left).sqrt()
    if size < SMALLEST_REMAINDER:
        raise ValueError(
            f"cosines and sines of frequency {frequency:g} radians a step must differ from "
            f"polynomials and from each other; {len(columns) + 1} of them on top of degree {skip} "
            f"do not, to 25 digits. Use Polynomials, fewer harmonics or a longer step."
        )
    return left / size


def _terms(lowest: int, x: Decimal) -> int:
    """Number of terms after which a bound of the coefficients is below SMALLEST_COEFFICIENT times
    that of index ``lowest``."""
    share, n = Decimal(1), lowest
    while share > SMALLEST_COEFFICIENT:  # ends, since the factors fall below 1/2
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


@dataclass(frozen=True)
class Fourier:
    """cos k w t and sin k w t, k from 1 to harmonics, and the constant, on [0, 1].

    Parameters
    ----------
    harmonics
        1 to 64
    frequency
        w, in radians a step, positive; 2 pi has the step as its period

    Raises
    ------
    ValueError
        For numbers outside these ranges.

    Notes
    -----
    phi_0 = 1; the derivatives of the others are orthonormal. The space does not contain linear
    functions, so a step is well posed but inconsistent with every rule, and `Galerkin` refuses it
    (claim V19): with w = 2 pi a free particle would never move, with w = 0.01 it deviates from a
    straight line by 8e-7 of a step. Only w of at most 1e-6 is accepted, where the space is
    numerically that of polynomials of degree 2 harmonics. `PolynomialFourier` adds the linear
    functions.

    Examples
    --------
    >>> galvi.Fourier(harmonics=2).dimension
    5
    """

    harmonics: int
    frequency: float = TWO_PI
    degree: ClassVar[int] = 0  # constants are the only polynomials
    exact: ClassVar[bool] = True  # basis and derivative work in decimals

    def __post_init__(self) -> None:
        harmonics, frequency = wave_numbers(self.harmonics, self.frequency)
        object.__setattr__(self, "harmonics", harmonics)
        object.__setattr__(self, "frequency", frequency)
        wave_slopes(0, harmonics, frequency)

    @property
    def dimension(self) -> int:
        """1 + 2 harmonics."""
        return 1 + 2 * self.harmonics

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        values = waves(t, 0, self.harmonics, self.frequency)
        return np.concatenate([t[:, None] * 0 + 1, values], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        slopes = wave_derivatives(t, 0, self.harmonics, self.frequency)
        return np.concatenate([t[:, None] * 0, slopes], axis=1)


@dataclass(frozen=True)
class PolynomialFourier:
    """Polynomials of at most this degree, and cos k w t and sin k w t, k from 1 to harmonics, on
    [0, 1].

    Parameters
    ----------
    degree
        1 to 64
    harmonics
        1 to 64
    frequency
        w, in radians a step, positive; 2 pi has the step as its period

    Raises
    ------
    ValueError
        For numbers outside these ranges, and where the waves are numerically polynomials.

    Notes
    -----
    phi_0 = 1; the derivatives of the others are P_{i-1}(2 t - 1) and then orthonormal functions
    orthogonal to them, so that the condition number of K is at most 2 degree - 1 for every w. A
    motion in the space, such as that of an oscillator with angular frequency w / h for the step h,
    is reproduced exactly if the rule integrates its action exactly. The space is efficient where
    unknowns are expensive; per force evaluation, Gauss collocation is more accurate
    (docs/why.md, "Waves").

    A free particle moves in a straight line to 1e-13 with 10, 13, 15, 18 and 26 Gauss points for
    1, 2, 3, 4 and 8 harmonics of 2 pi and degrees up to 4 (about 9 + 0.37 harmonics w in general);
    with fewer, `Galerkin` refuses the pair as inconsistent.

    Examples
    --------
    >>> space = galvi.PolynomialFourier(degree=2, harmonics=1)
    >>> space.dimension, galvi.Galerkin(space, galvi.gauss(10)).stages
    (5, 10)
    """

    degree: int
    harmonics: int
    frequency: float = TWO_PI
    exact: ClassVar[bool] = True  # basis and derivative work in decimals

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, MAX_DEGREE))
        harmonics, frequency = wave_numbers(self.harmonics, self.frequency)
        object.__setattr__(self, "harmonics", harmonics)
        object.__setattr__(self, "frequency", frequency)
        wave_slopes(self.degree, harmonics, frequency)

    @property
    def dimension(self) -> int:
        """degree + 1 + 2 harmonics."""
        return self.degree + 1 + 2 * self.harmonics

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        values = waves(t, self.degree, self.harmonics, self.frequency)
        return np.concatenate([Polynomials(self.degree).basis(t), values], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        slopes = wave_derivatives(t, self.degree, self.harmonics, self.frequency)
        return np.concatenate([Polynomials(self.degree).derivative(t), slopes], axis=1)
