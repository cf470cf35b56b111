"""Piecewise cubics with a continuous derivative."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.spaces.pieces import in_piece, place_in_pieces
from galvi.spaces.polynomials import HIGHEST


@dataclass(frozen=True)
class PiecewiseHermite:
    """Cubic on each of ``pieces`` equal parts of [0, 1], with a continuous derivative.

    pieces  1 to 64; one piece gives ``Polynomials(3)``

    phi_0 = 1; the derivatives of the others span the continuous piecewise quadratics: a hat of
    height 1 at each of the pieces + 1 joints and ends, then 6 u (1 - u) on each piece. The second
    derivative jumps at joints: use ``composite(rule, pieces)``.

    Raises ValueError for a number of pieces outside 1 to 64.
    """

    pieces: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", input_checks.whole("pieces", self.pieces, 1, HIGHEST))

    @property
    def degree(self) -> int:
        """3."""
        return 3

    @property
    def dimension(self) -> int:
        """2 (pieces + 1), the values and derivatives at the joints and ends."""
        return 2 * (self.pieces + 1)

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return True

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        u = place_in_pieces(t, self.pieces)
        risen = self._joined(u * u / 2, u - u * u / 2, u * u * (3 - 2 * u)) / self.pieces
        return np.concatenate([t[:, None] * 0 + 1, risen], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        u = place_in_pieces(t, self.pieces)
        here = in_piece(t, self.pieces)
        slopes = self._joined(u * here, (1 - u) * here, 6 * u * (1 - u) * here)
        return np.concatenate([t[:, None] * 0, slopes], axis=1)

    def _joined(self, rising: Any, falling: Any, bubble: Any) -> Any:
        """Hats, from their rising and falling parts on each piece, then the bubbles."""
        none = rising[:, :1] * 0
        hats = np.concatenate([none, rising], axis=1) + np.concatenate([falling, none], axis=1)
        return np.concatenate([hats, bubble], axis=1)
