"""A step cut into equal pieces, for floats and for decimals alike."""

from __future__ import annotations

from typing import Any

import numpy as np

JOINT = 1e-13  # of a piece: this near to a joint is on it


def place_in_pieces(t: Any, pieces: int) -> Any:
    """How far t has come through each piece, 0 to 1, as (k, pieces) for t of shape (k,)."""
    place = t[:, None] * pieces - np.arange(pieces).astype(t.dtype)
    return np.minimum(np.maximum(place, place * 0), place * 0 + 1)


def in_piece(t: Any, pieces: int) -> Any:
    """1 for the piece that t lies in and 0 for others, (k, pieces); at a joint the later piece."""
    passed = t[:, None] * pieces - np.arange(1, pieces).astype(t.dtype)
    number = np.sum(passed.astype(np.float64) > -JOINT, axis=1)
    return (number[:, None] == np.arange(pieces)).astype(np.int64)
