"""Derivatives by Ridders' method (Adv. Eng. Software 4 (1982) 75), for potentials alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from galvi.arrays import Array

ROWS = 12
LARGEST, RATIO = 2.0**-4, 2.0


def derivative(function: Callable[[float], float], scale: float) -> float:
    """f'(0), from central differences of halved steps, extrapolated to zero.

    scale  length over which the function changes: the first step is a sixteenth of it

    The entry of the extrapolation table that differs least from its neighbours is taken.
    """
    best, error, above = np.nan, np.inf, []
    for row in range(ROWS):
        step = LARGEST * scale / RATIO**row
        entries = [(function(step) - function(-step)) / (2.0 * step)]
        for k, coarser in enumerate(above):
            factor = RATIO ** (2 * (k + 1))
            entries.append((factor * entries[k] - coarser) / (factor - 1.0))
            change = max(abs(entries[-1] - entries[-2]), abs(entries[-1] - coarser))
            if change <= error:
                best, error = entries[-1], change
        above = entries
    return float(best)


def gradient(function: Callable[[Any], float], q: Array) -> Array:
    """df/dq, (d,), with max |q| for the scale, or 1."""
    scale = float(np.max(np.abs(q))) or 1.0
    units = np.eye(q.size)
    return np.array(
        [derivative(lambda s, unit=unit: float(function(q + s * unit)), scale) for unit in units]
    )
