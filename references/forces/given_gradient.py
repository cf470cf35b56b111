"""Does a gradient that was given beside a known potential belong to it?"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from galvi.arrays import Array

ROUNDING = 1e-12  # relative difference of two correct ways to evaluate a gradient
DISTANCES = (0.01, 0.01, 0.1, 0.1, 1.0, 1.0, 3.0, 3.0)


def agrees(
    given: Callable[[Array], Any], known: Callable[[Array], Array], points: Iterable[Array]
) -> bool:
    """Whether both return the same array, to rounding, at all points; no when one raises."""
    for point in points:
        try:
            values = np.asarray(given(point.copy()), dtype=np.float64)
        except Exception:  # a user's function may raise anything
            return False
        exact = known(point)
        if values.shape != exact.shape:
            return False
        if not np.max(np.abs(values - exact)) <= ROUNDING * np.max(np.abs(exact)):
            return False
    return True


def points_around(q0: Array) -> list[Array]:
    """q0 and points near and far from it, the same in every call."""
    size, draw = float(np.max(np.abs(q0))) or 1.0, np.random.default_rng(0)
    return [q0, *(q0 + size * far * draw.standard_normal(q0.shape) for far in DISTANCES)]
