"""Continuous piecewise polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.spaces.legendre import integrals, legendre
from galvi.spaces.pieces import in_piece, place_in_pieces
from galvi.spaces.polynomials import HIGHEST


@dataclass(frozen=True)
class PiecewisePolynomials:
    """Continuous functions on [0, 1], of at most this degree on each of ``pieces`` equal parts.

    degree  1 to 64
    pieces  1 to 64; one is `Polynomials`

    phi_0 = 1; the derivatives of the others are Legendre polynomials on one piece each, 0 elsewhere
    (at a joint, the values of the later piece). Since they jump at the joints, the space needs a
    composite rule, ``composite(rule, pieces)``, of a rule without the end point 1 such as gauss or
    radau from the left: a step with ``composite(gauss(degree), pieces)`` is ``pieces`` steps of
    Gauss collocation.

    Raises ValueError for numbers outside these ranges.
    """

    degree: int
    pieces: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, HIGHEST))
        object.__setattr__(self, "pieces", input_checks.whole("pieces", self.pieces, 1, HIGHEST))

    @property
    def dimension(self) -> int:
        """1 + degree pieces."""
        return 1 + self.degree * self.pieces

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return True

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        u = place_in_pieces(t, self.pieces).reshape(-1)
        risen = integrals(u, self.degree).reshape(len(t), -1) / self.pieces
        return np.concatenate([t[:, None] * 0 + 1, risen], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        u = place_in_pieces(t, self.pieces).reshape(-1)
        slopes = legendre(2 * u - 1, self.degree - 1).reshape(len(t), self.pieces, self.degree)
        here = slopes * in_piece(t, self.pieces)[:, :, None]
        return np.concatenate([t[:, None] * 0, here.reshape(len(t), -1)], axis=1)
