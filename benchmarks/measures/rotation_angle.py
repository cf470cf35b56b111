"""Angles between attitudes."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array


def turns(first: Array, second: Array) -> Array:
    """Angle of first^T second in [0, pi], (k,), for rotations (k, 3, 3); exact near 0 and pi.

    With c = (trace - 1) / 2 and s the size of the skew part, the angle is atan2(s, c).
    """
    relative = np.einsum("kji,kjl->kil", first, second)
    skew = relative - np.swapaxes(relative, 1, 2)
    sine = 0.5 * np.sqrt(skew[:, 2, 1] ** 2 + skew[:, 0, 2] ** 2 + skew[:, 1, 0] ** 2)
    angle: Array = np.arctan2(sine, 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0))
    return angle
