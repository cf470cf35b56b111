"""The drag of a rigid body in a medium, by the box of its inertia: MuJoCo's "Inertia model"."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.systems.trees.joint import Link
from galvi.systems.trees.rigid_tree import GEOMETRY_ROUNDING

# MuJoCo gives a body of at most this mass no drag, and replaces smaller sums of moments by it.
MUJOCO_MINVAL = 1e-15


def drag_coefficients(link: Link, axes: Array, medium: Any) -> Array:
    """Drag coefficients of galvi.kernels.trees.joint_forces, (8,): the linear ones of w and of v,
    then the quadratic ones of w (3,) and of v (3,); zeros for a mass of at most MUJOCO_MINVAL.

    Parameters
    ----------
    axes : array, shape (3, 3)
        columns: the principal axes of the link's inertia I, and so of the box, in the link's frame
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
    squares[squares <= GEOMETRY_ROUNDING * np.sum(moments)] = 0.0  # of a plate or a rod
    x, y, z = np.sqrt(6.0 * np.maximum(squares, MUJOCO_MINVAL) / link.mass)
    mean_side = (x + y + z) / 3.0
    linear = np.pi * viscosity * np.array([mean_side**3, 3.0 * mean_side])
    quadratic_of_w = (
        density / 64.0 * np.array([x * (y**4 + z**4), y * (x**4 + z**4), z * (x**4 + y**4)])
    )
    quadratic_of_v = 0.5 * density * np.array([y * z, x * z, x * y])
    return np.concatenate([linear, quadratic_of_w, quadratic_of_v])
