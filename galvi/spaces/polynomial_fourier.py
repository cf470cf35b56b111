"""Polynomials and trigonometric functions: for fast oscillations on top of a slow motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.spaces.polynomials import HIGHEST, Polynomials
from galvi.spaces.trigonometric import wave_derivatives, wave_numbers, wave_slopes, waves

TURN = 6.283185307179586


@dataclass(frozen=True)
class PolynomialFourier:
    """Polynomials of at most this degree, cos k w t and sin k w t, k = 1 .. harmonics, on [0, 1].

    degree     1 to 64
    harmonics  1 to 64
    frequency  w, in radians a step, positive; 2 pi has the step as its period

    phi_0 = 1; the derivatives of the others are P_{i-1}(2 t - 1) and then orthonormal functions
    orthogonal to them, so that the condition number of K is at most 2 degree - 1 for every w. A
    motion in the space, such as that of an oscillator with angular frequency w / h for the step h,
    is reproduced exactly if the rule integrates its action exactly. The space is efficient where
    unknowns are expensive; per force evaluation, Gauss collocation is more accurate (`python -m
    benchmarks.experiments.two_time_scales`).

    A free particle moves in a straight line to 1e-13 with 10, 13, 15, 18 and 26 Gauss points for
    1, 2, 3, 4 and 8 harmonics of 2 pi and degrees up to 4 (about 9 + 0.37 harmonics w in general);
    with fewer, `Galerkin` refuses the pair as inconsistent.

    Raises ValueError for numbers outside these ranges, and where the waves are numerically
    polynomials.
    """

    degree: int
    harmonics: int
    frequency: float = TURN

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, HIGHEST))
        harmonics, frequency = wave_numbers(self.harmonics, self.frequency)
        object.__setattr__(self, "harmonics", harmonics)
        object.__setattr__(self, "frequency", frequency)
        wave_slopes(self.degree, harmonics, frequency)

    @property
    def dimension(self) -> int:
        """degree + 1 + 2 harmonics."""
        return self.degree + 1 + 2 * self.harmonics

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return True

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        values = waves(t, self.degree, self.harmonics, self.frequency)
        return np.concatenate([Polynomials(self.degree).basis(t), values], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        slopes = wave_derivatives(t, self.degree, self.harmonics, self.frequency)
        return np.concatenate([Polynomials(self.degree).derivative(t), slopes], axis=1)
