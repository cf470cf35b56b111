"""Extrapolation of Gragg's midpoint rule (Hairer, Norsett, Wanner, Solving ODEs I, II.9)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from galvi.arrays import Array

COLUMNS = 6  # of the table of extrapolation: order 12; with more, round-off grows


def extrapolated(slope: Callable[[Array], Array], y: Array, duration: float, steps: int) -> Array:
    """y(duration) of y' = slope(y), in the precision of y, by equal steps of order 12."""
    h = y.dtype.type(duration) / steps
    for _ in range(steps):
        first = slope(y)
        table: list[Array] = []
        for j in range(1, COLUMNS + 1):
            row = [_midpoint(slope, y, first, h, 2 * j)]
            for k, above in enumerate(table, start=1):
                weight = (y.dtype.type(j) / (j - k)) ** 2 - 1
                row.append(row[-1] + (row[-1] - above) / weight)
            table = row
        y = table[-1]
    return y


def _midpoint(
    slope: Callable[[Array], Array], y: Array, first: Array, h: np.floating, n: int
) -> Array:
    """h by n steps of the midpoint rule, the first one Euler's."""
    part = h / n
    before, now = y, y + part * first
    for _ in range(n - 1):
        before, now = now, before + 2 * part * slope(now)
    return now
