"""Continuous chart coordinates along a path that rotates by more than half a turn."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Chart
from galvi.groups.group import Group
from galvi.kernels.lie.chart_functions import angle_of, coordinate_of
from galvi.kernels.lie.product import GROUPS

TURN = 2.0 * np.pi


def unwrapped(chart: Chart, group: Group, xi: Array) -> Array:
    """Coordinates (k, d) of a path from 0, with their rotations made continuous.

    A rotation by an angle about an axis is also one by angle - 2 pi m; the m nearest to the
    coordinates before is taken, and the translation of a rigid motion is changed to match. The
    rotation must stay below the chart's limit, except in the exponential chart, whose map extends
    beyond it.
    """
    path, start = xi.copy(), 0
    for number, d, _, rotations in group.layout:
        own = path[:, start : start + d]
        for k in range(1, len(path) if rotations else 0):
            w = _followed(chart, own[k - 1, :rotations], own[k, :rotations])
            if w is not None:
                GROUPS[number].with_rotation(chart.number, own[k].copy(), w, own[k])
        start += d
    return path


def _followed(chart: Chart, last: Array, here: Array) -> Array | None:
    """The coordinates of the same rotation nearest to ``last``; None if these are ``here``."""
    size, last_size = float(np.linalg.norm(here)), float(np.linalg.norm(last))
    if last_size == 0.0:
        return None
    axis = here / size if size > 0.0 else last / last_size
    angle, before = (angle_of(chart.number, x) for x in (size, last_size))
    turns = round((before / last_size * float(last @ axis) - angle) / TURN)
    return coordinate_of(chart.number, angle + turns * TURN) * axis if turns else None
