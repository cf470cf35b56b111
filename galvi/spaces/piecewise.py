"""Spaces on several pieces of [0, 1]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.spaces.polynomials import MAX_DEGREE, integrals, legendre

JOINT_SHARE = 1e-13  # distance from a joint, over the length of a piece, that counts as zero


def place_in_pieces(t: Any, pieces: int) -> Any:
    """The share of each piece that lies before t, (k, pieces) for t of shape (k,)."""
    share = t[:, None] * pieces - np.arange(pieces).astype(t.dtype)
    return np.minimum(np.maximum(share, share * 0), share * 0 + 1)


def in_piece(t: Any, pieces: int) -> Any:
    """1 for the piece that contains t, else 0, (k, pieces); at a joint the later piece."""
    passed = t[:, None] * pieces - np.arange(1, pieces).astype(t.dtype)
    number = np.sum(passed.astype(np.float64) > -JOINT_SHARE, axis=1)
    return (number[:, None] == np.arange(pieces)).astype(np.int64)


@dataclass(frozen=True)
class PiecewisePolynomials:
    """Continuous functions on [0, 1], of at most this degree on each of ``pieces`` equal parts.

    Parameters
    ----------
    degree
        1 to 64
    pieces
        1 to 64; one is `Polynomials`

    Raises
    ------
    ValueError
        For numbers outside these ranges.

    Notes
    -----
    phi_0 = 1; the derivatives of the others are Legendre polynomials on one piece each, 0 elsewhere
    (at a joint, the values of the later piece). Since they jump at the joints, the space needs a
    composite rule, ``composite(rule, pieces)``, of a rule without the end point 1 such as gauss or
    radau from the left: a step with ``composite(gauss(degree), pieces)`` is ``pieces`` steps of
    Gauss collocation.

    Examples
    --------
    >>> space = galvi.PiecewisePolynomials(degree=2, pieces=3)
    >>> galvi.Galerkin(space, galvi.composite(galvi.gauss(2), 3)).order
    4
    """

    degree: int
    pieces: int
    exact: ClassVar[bool] = True  # basis and derivative work in decimals

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, MAX_DEGREE))
        object.__setattr__(self, "pieces", input_checks.whole("pieces", self.pieces, 1, MAX_DEGREE))

    @property
    def dimension(self) -> int:
        """1 + degree pieces."""
        return 1 + self.degree * self.pieces

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        u = place_in_pieces(t, self.pieces).reshape(-1)
        risen = integrals(u, self.degree).reshape(len(t), -1) / self.pieces
        return np.concatenate([t[:, None] * 0 + 1, risen], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        u = place_in_pieces(t, self.pieces).reshape(-1)
        slopes = legendre(2 * u - 1, self.degree - 1).reshape(len(t), self.pieces, self.degree)
        masked = slopes * in_piece(t, self.pieces)[:, :, None]
        return np.concatenate([t[:, None] * 0, masked.reshape(len(t), -1)], axis=1)


@dataclass(frozen=True)
class PiecewiseHermite:
    """Cubic on each of ``pieces`` equal parts of [0, 1], with a continuous derivative.

    Parameters
    ----------
    pieces
        1 to 64; one piece gives ``Polynomials(3)``

    Raises
    ------
    ValueError
        For a number of pieces outside 1 to 64.

    Notes
    -----
    phi_0 = 1; the derivatives of the others span the continuous piecewise quadratics: a hat of
    height 1 at each of the pieces + 1 joints and ends, then 6 u (1 - u) on each piece. The second
    derivative jumps at joints: use ``composite(rule, pieces)``.

    Examples
    --------
    >>> space = galvi.PiecewiseHermite(pieces=2)
    >>> space.degree, space.dimension
    (3, 6)
    """

    pieces: int
    degree: ClassVar[int] = 3
    exact: ClassVar[bool] = True  # basis and derivative work in decimals

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", input_checks.whole("pieces", self.pieces, 1, MAX_DEGREE))

    @property
    def dimension(self) -> int:
        """2 (pieces + 1), the values and derivatives at the joints and ends."""
        return 2 * (self.pieces + 1)

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, dimension), for t of shape (k,)."""
        u = place_in_pieces(t, self.pieces)
        risen = self._joined(u * u / 2, u - u * u / 2, u * u * (3 - 2 * u)) / self.pieces
        return np.concatenate([t[:, None] * 0 + 1, risen], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), (k, dimension)."""
        u = place_in_pieces(t, self.pieces)
        indicator = in_piece(t, self.pieces)
        slopes = self._joined(u * indicator, (1 - u) * indicator, 6 * u * (1 - u) * indicator)
        return np.concatenate([t[:, None] * 0, slopes], axis=1)

    def _joined(self, rising: Any, falling: Any, bubble: Any) -> Any:
        """Hats, from their rising and falling parts on each piece, then the bubbles."""
        none = rising[:, :1] * 0
        hats = np.concatenate([none, rising], axis=1) + np.concatenate([falling, none], axis=1)
        return np.concatenate([hats, bubble], axis=1)
