"""Initial scales of the finite differences of a Lagrangian, from its group and state."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.lie import product

SMALLEST = 1e-24  # coordinates and velocities below it are taken as zero


def difference_scales(group: Group, q: Array, v: Array) -> tuple[Array, Array]:
    """Estimated lengths (d,), (d,) over which a Lagrangian changes with q and with v.

    For q: 1 radian for rotations; for translations the largest coordinate or velocity of the same
    factor of the group. For v: the largest velocity of the factor, else its largest coordinate.
    1 where all of these vanish.
    """
    by_q, by_v = np.ones(v.size), np.ones(v.size)
    sizes, start = np.empty(v.size), 0
    product.position_scale(group.layout, np.array(q, dtype=np.float64).ravel(), sizes)
    for _, d, _, rotations in group.layout:
        turns, moves = slice(start, start + rotations), slice(start + rotations, start + d)
        far, fast = (float(np.max(np.abs(x), initial=0.0)) for x in (sizes[moves], v[moves]))
        by_q[moves] = _first(max(far, fast))
        by_v[moves] = _first(fast, far)
        by_v[turns] = _first(float(np.max(np.abs(v[turns]), initial=0.0)))
        start += d
    return by_q, by_v


def _first(*sizes: float) -> float:
    return next((size for size in sizes if size > SMALLEST), 1.0)
