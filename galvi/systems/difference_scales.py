"""Initial scales of the finite differences of a Lagrangian, from its group and state."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.lie import charts
from galvi.kernels.lie.charts import RN

SMALLEST = 1e-24  # coordinates and velocities below it are taken as zero


def difference_scales(group: Group, q: Array, v: Array) -> tuple[Array, Array]:
    """Estimated lengths (d,), (d,) over which a Lagrangian changes with q and with v.

    For q: 1 radian for rotations; for translations the largest coordinate or velocity of the same
    factor of the group. For v: the largest velocity of the factor, else its largest coordinate.
    1 where all of these vanish.
    """
    by_q, by_v = np.ones(v.size), np.ones(v.size)
    flat, first, start = np.ravel(q), 0, 0
    for kind, n in group.layout:
        d = charts.dimension(kind, n)
        turning = 0 if kind == RN else min(d, 3)
        turns, moves = slice(start, start + turning), slice(start + turning, start + d)
        entries = charts.entries(kind, n)
        own = flat[first : first + entries]
        where = own if kind == RN else own[3:12:4] if d > turning else own[:0]
        far, fast = (float(np.max(np.abs(x), initial=0.0)) for x in (where, v[moves]))
        by_q[moves] = _first(max(far, fast))
        by_v[moves] = _first(fast, far)
        by_v[turns] = _first(float(np.max(np.abs(v[turns]), initial=0.0)))
        first, start = first + entries, start + d
    return by_q, by_v


def _first(*sizes: float) -> float:
    return next((size for size in sizes if size > SMALLEST), 1.0)
