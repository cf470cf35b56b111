"""What a user's function returned, checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array


def returned_array(name: str, values: Any, shape: tuple[int, ...], expected: str) -> Array:
    """What a user's function returned, finite or not; ValueError for another shape or no reals.

    expected  "an array of shape ...", in words
    """
    result = np.asarray(values)
    if result.shape != shape:
        raise ValueError(f"{name} must return {expected}; received shape {result.shape}.")
    if result.dtype.kind not in "iuf":
        raise ValueError(
            f"{name} must return {expected}, of real numbers; received numbers of type "
            f"{result.dtype}."
        )
    return np.ascontiguousarray(result, dtype=np.float64)
