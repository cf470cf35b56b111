"""Exponential coordinates along a path, beyond half a turn."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.lie import charts, se3
from galvi.kernels.lie.charts import RN, SO2

EXPONENTIAL = 1
TURN = 2.0 * np.pi


def unwrapped(group: Group, xi: Array) -> Array:
    """Exponential coordinates (k, d) of a path from 0, with rotations followed continuously.

    A rotation has the coordinates w and (|w| - 2 pi m) w / |w|, of which those nearest to the last
    place are taken; the translation of a rigid motion goes with them.
    """
    path, start = xi.copy(), 0
    for kind, n in group.layout:
        d = charts.dimension(kind, n)
        if kind == SO2:
            path[:, start] = np.unwrap(xi[:, start])
        elif kind != RN:
            for k in range(1, len(path)):
                _follow(path[k - 1, start : start + d], path[k, start : start + d])
        start += d
    return path


def _follow(last: Array, here: Array) -> None:
    """here <- the coordinates of the same element that are nearest to the last ones."""
    w = here[:3].copy()
    size = float(np.linalg.norm(w))
    if size == 0.0:
        axis = last[:3] / (float(np.linalg.norm(last[:3])) or 1.0)
    else:
        axis = w / size
    turns = round((float(last[:3] @ axis) - size) / TURN)
    if turns == 0:
        return
    here[:3] = (size + turns * TURN) * axis
    if here.size == 6:
        V = np.empty((3, 3))
        se3.shift_matrix(EXPONENTIAL, w, V)
        shift = V @ here[3:]
        se3.shift_matrix(EXPONENTIAL, here[:3].copy(), V)
        here[3:] = np.linalg.solve(V, shift)
