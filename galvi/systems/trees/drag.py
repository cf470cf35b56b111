"""The drag of a rigid body in a medium, by the box of its inertia: MuJoCo's "Inertia model"."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.systems.trees.joint import Link
from galvi.systems.trees.rigid_tree import GEOMETRY_ROUNDING

MUJOCO_MINVAL = 1e-15  # mass or moment below which MuJoCo takes it for this


def drag_coefficients(link: Link, axes: Array, medium: Any) -> Array:
    """b of w and v, and b_1 of w (3,) and v (3,), of galvi.kernels.trees.joint_forces, (8,); zeros
    for a link without mass.

    Parameters
    ----------
    axes : array, shape (3, 3)
        of the box, which are those of the link's inertia I, in its frame
    medium : array, shape (2,)
        density and viscosity

    Notes
    -----
    The sides of the box are sqrt(6 (I_j + I_k - I_i) / m).
    """
    density, viscosity = medium
    if link.mass <= MUJOCO_MINVAL:
        return np.zeros(8)
    moments = np.diag(axes.T @ link.inertia @ axes)
    squares = np.sum(moments) - 2.0 * moments
    squares[squares <= GEOMETRY_ROUNDING * np.sum(moments)] = 0.0  # rounding
    x, y, z = np.sqrt(6.0 * np.maximum(squares, MUJOCO_MINVAL) / link.mass)
    mean = (x + y + z) / 3.0
    viscous = np.pi * viscosity * np.array([mean**3, 3.0 * mean])
    turned = density / 64.0 * np.array([x * (y**4 + z**4), y * (x**4 + z**4), z * (x**4 + y**4)])
    moved = 0.5 * density * np.array([y * z, x * z, x * y])
    return np.concatenate([viscous, turned, moved])
