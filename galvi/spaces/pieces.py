"""Equal pieces of [0, 1], for floats and decimals."""

from __future__ import annotations

from typing import Any

import numpy as np

JOINT = 1e-13  # share of a piece within which a point counts as being on a joint


def place_in_pieces(t: Any, pieces: int) -> Any:
    """The share of each piece that lies before t, (k, pieces) for t of shape (k,)."""
    place = t[:, None] * pieces - np.arange(pieces).astype(t.dtype)
    return np.minimum(np.maximum(place, place * 0), place * 0 + 1)


def in_piece(t: Any, pieces: int) -> Any:
    """1 for the piece that contains t, else 0, (k, pieces); at a joint the later piece."""
    passed = t[:, None] * pieces - np.arange(1, pieces).astype(t.dtype)
    number = np.sum(passed.astype(np.float64) > -JOINT, axis=1)
    return (number[:, None] == np.arange(pieces)).astype(np.int64)
