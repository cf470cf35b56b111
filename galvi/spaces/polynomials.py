"""Polynomials, as integrals of Legendre polynomials; also the Lagrange basis on their nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.spaces.legendre import integrals, legendre

HIGHEST = 64


@dataclass(frozen=True)
class Polynomials:
    """Polynomials of at most this degree, 1 to 64, on [0, 1].

    phi_0 = 1 and phi_i(t) = integral of P_{i-1}(2 s - 1) over s in [0, t], so that the derivatives
    are orthogonal. H calls n = degree + 1 the number of basis functions.

    Raises ValueError for a degree outside 1 to 64.
    """

    degree: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, HIGHEST))

    @property
    def dimension(self) -> int:
        """degree + 1."""
        return self.degree + 1

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return True

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, degree + 1), for t of shape (k,)."""
        return np.concatenate([t[:, None] * 0 + 1, integrals(t, self.degree)], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k) = P_{i-1}(2 t_k - 1), (k, degree + 1)."""
        P = legendre(2 * t - 1, self.degree)
        return np.concatenate([P[:, :1] * 0, P[:, :-1]], axis=1)

    @property
    def nodes(self) -> Array:
        """The degree + 1 Chebyshev points of H 2.2, increasing from 0 to 1."""
        angles = np.arange(self.degree + 1) * (np.pi / self.degree)
        return read_only(np.sin(0.5 * angles) ** 2)

    def lagrange(self, t: Any) -> Array:
        """The Lagrange basis on ``nodes`` at t of shape (k,), as (k, degree + 1).

        Barycentric formula of the second kind (Berrut and Trefethen, SIAM Rev. 46 (2004), 4.2 and
        5.4); it reproduces every polynomial of the space from its nodal values.
        """
        weights = (-1.0) ** np.arange(self.degree + 1)
        weights[[0, -1]] *= 0.5
        gap = np.asarray(t, dtype=np.float64)[:, None] - self.nodes[None, :]
        hit = (gap == 0.0).astype(np.float64)
        on_node = hit.any(axis=1, keepdims=True)
        terms = np.where(on_node, hit, weights / np.where(on_node, 1.0, gap))
        values: Array = terms / np.sum(terms, axis=1, keepdims=True)
        return values
