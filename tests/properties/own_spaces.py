"""Spaces of a user: Bernstein polynomials that break a promise on demand, and others."""

from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Bernstein:
    """Bernstein polynomials, the first replaced by 1; ``broken`` names the promise that fails."""

    degree: Any = 3
    dimension: Any = 4
    exact: Any = False
    broken: str = ""

    def basis(self, t):
        n = self.dimension - 1
        values = [comb(n, i) * t**i * (1 - t) ** (n - i) for i in range(n + 1)]
        if self.broken != "constant":
            values[0] = np.ones_like(t)
        if self.broken == "nan":
            values[2] = np.where(t > 0.5, np.nan, values[2])
        if self.broken == "complex":
            values[2] = values[2] + 0j
        if self.broken == "fewer":
            values.pop()
        return np.stack(values, axis=0 if self.broken == "turned" else -1)

    def derivative(self, t):
        n = self.dimension - 1
        if self.broken == "flat":
            return np.zeros_like(t)
        lower = [0 * t, *(comb(n - 1, i) * t**i * (1 - t) ** (n - 1 - i) for i in range(n)), 0 * t]
        slopes = [n * (lower[i] - lower[i + 1]) for i in range(n + 1)]
        slopes[0] = 0 * t
        if self.broken == "sign":
            slopes[2] = -slopes[2]
        return np.stack(slopes, axis=-1)


@dataclass(frozen=True)
class Even(Bernstein):
    """Even powers of t, which promise degree 3 and do not contain t."""

    def basis(self, t):
        return np.stack([t ** (2 * i) for i in range(4)], axis=-1)

    def derivative(self, t):
        return np.stack([2 * i * t ** max(2 * i - 1, 0) for i in range(4)], axis=-1)


class WithoutDegree:
    """A space without its degree."""

    dimension, exact = 4, False
    basis, derivative = Bernstein.basis, Bernstein.derivative


@dataclass
class Unhashable:
    """A space without a hash."""

    degree: int = 3
    dimension: int = 4
    exact: bool = False
    basis, derivative, broken = Bernstein.basis, Bernstein.derivative, ""


@dataclass(frozen=True)
class Sines:
    """{1, sin(2 pi t), cos(2 pi t)}: well posed, but without linear functions (claim V19)."""

    dimension: int = 3
    degree: int = 0
    exact: bool = False

    def basis(self, t):
        return np.stack([np.ones_like(t), np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=-1)

    def derivative(self, t):
        angle = 2 * np.pi * t
        return 2 * np.pi * np.stack([0 * t, np.cos(angle), -np.sin(angle)], axis=-1)


@dataclass(frozen=True)
class Monomials:
    """A user's space in plain floats."""

    degree: int
    exact: bool = False

    @property
    def dimension(self):
        return self.degree + 1

    def basis(self, t):
        return np.stack([t**i for i in range(self.dimension)], axis=-1)

    def derivative(self, t):
        return np.stack([i * t ** max(i - 1, 0) for i in range(self.dimension)], axis=-1)
