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
        for k in range(_first_change(chart, own[:, :rotations]), len(path)):
            w = _followed(chart, own[k - 1, :rotations], own[k, :rotations])
            if w is not None:
                GROUPS[number].with_rotation(chart.number, own[k].copy(), w, own[k])
        start += d
    return path


def _first_change(chart: Chart, w: Array) -> int:
    """The first row of w (k, 3 or 1) that `_followed` may change; k for none, and without columns.

    Most paths have none, and one pass over arrays is ten times as fast as a loop.
    """
    if w.shape[1] == 0:
        return len(w)
    size = np.linalg.norm(w, axis=1)
    angle = np.array([angle_of(chart.number, x) for x in size.tolist()])
    last, here = size[:-1], size[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(here > 0.0, np.sum(w[:-1] * w[1:], axis=1) / (last * here), 1.0)
        changed = (np.round((angle[:-1] * cosine - angle[1:]) / TURN) != 0.0) & (last > 0.0)
    return 1 + int(np.argmax(changed)) if np.any(changed) else len(w)


def _followed(chart: Chart, last: Array, here: Array) -> Array | None:
    """The coordinates of the same rotation nearest to ``last``; None if these are ``here``."""
    size, last_size = float(np.linalg.norm(here)), float(np.linalg.norm(last))
    if last_size == 0.0:
        return None
    axis = here / size if size > 0.0 else last / last_size
    angle, before = (angle_of(chart.number, x) for x in (size, last_size))
    turns = round((before / last_size * float(last @ axis) - angle) / TURN)
    return coordinate_of(chart.number, angle + turns * TURN) * axis if turns else None
