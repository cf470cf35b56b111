"""The array type of the package: float64, C order, read-only in public values."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def read_only(array: Array) -> Array:
    """The same array, C-contiguous and not writeable."""
    array = np.ascontiguousarray(array) if array.ndim else array
    array.setflags(write=False)
    return array
