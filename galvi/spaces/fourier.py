"""Cosines and sines alone: an example of a well-posed but inconsistent space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.spaces.polynomial_fourier import TURN
from galvi.spaces.trigonometric import wave_derivatives, wave_numbers, wave_slopes, waves


@dataclass(frozen=True)
class Fourier:
    """cos k w t and sin k w t, k = 1 .. harmonics, and the constant, on [0, 1].

    harmonics  1 to 64
    frequency  w, in radians a step, positive; 2 pi has the step as its period

    phi_0 = 1; the derivatives of the others are orthonormal. The space does not contain linear
    functions, so a step is well posed but inconsistent with every rule, and `Galerkin` refuses it
    (claim V19): with w = 2 pi a free particle would never move, with w = 0.01 it deviates from a
    straight line by 8e-7 of a step. Only w of at most 1e-6 is accepted, where the space is
    numerically that of polynomials of degree 2 harmonics. `PolynomialFourier` adds the linear
    functions.

    Raises ValueError for numbers outside these ranges.
    """

    harmonics: int
    frequency: float = TURN

    def __post_init__(self) -> None:
        harmonics, frequency = wave_numbers(self.harmonics, self.frequency)
        object.__setattr__(self, "harmonics", harmonics)
        object.__setattr__(self, "frequency", frequency)
        wave_slopes(0, harmonics, frequency)

    @property
    def dimension(self) -> int:
        """1 + 2 harmonics."""
        return 1 + 2 * self.harmonics

    @property
    def degree(self) -> int:
        """0: constants are the only polynomials."""
        return 0

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return True

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        values = waves(t, 0, self.harmonics, self.frequency)
        return np.concatenate([t[:, None] * 0 + 1, values], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        slopes = wave_derivatives(t, 0, self.harmonics, self.frequency)
        return np.concatenate([t[:, None] * 0, slopes], axis=1)
