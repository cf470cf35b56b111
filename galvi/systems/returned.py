"""Checks the array that a user's function returned."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array


def returned_array(name: str, values: Any, shape: tuple[int, ...], expected: str) -> Array:
    """The values as a contiguous float64 array; ValueError for another shape or non-real numbers.

    name      of the function, for the message
    expected  the expected array in words, for the message: "an array of shape ..."

    Non-finite values pass.
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
