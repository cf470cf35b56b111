"""Rigid motions of the plane: rotation and translation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Layout, one_factor
from galvi.groups.matrices import check_motion, inverse_motion
from galvi.kernels.lie.groups import se2


@dataclass(frozen=True)
class SE2:
    """Matrices [[R, x], [0, 1]] of shape (3, 3): a body with attitude R and origin at x.

    Velocities (3,) are the angular velocity and the linear velocity in the body's frame:
    g' = g [[0, -w, v_x], [w, 0, v_y], [0, 0, 0]].
    """

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def shape(self) -> tuple[int, ...]:
        """(3, 3)."""
        return (3, 3)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(se2, 3, 9, 1)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rigid motion of the plane."""
        check_motion(name, g, 2)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """[[R^T, -R^T x], [0, 1]]."""
        return inverse_motion(g)

    def bracket(self, v: Array, w: Array) -> Array:
        """(0, J (v_r w_t - w_r v_t)) for v = (v_r, v_t), J = [[0, -1], [1, 0]]."""
        x, y = v[0] * w[1:] - w[0] * v[1:]
        return np.array([0.0, -y, x])
