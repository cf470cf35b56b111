"""Rigid motions of space: rotation and translation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Layout, one_factor
from galvi.groups.matrices import check_motion, inverse_motion
from galvi.kernels.lie.groups import se3


@dataclass(frozen=True)
class SE3:
    """Matrices [[R, x], [0, 1]] of shape (4, 4): a body with attitude R and origin at x.

    Velocities (6,) are the angular and the linear velocity in the body's frame:
    g' = g [[hat(w), v], [0, 0]].
    """

    @property
    def dimension(self) -> int:
        """6."""
        return 6

    @property
    def shape(self) -> tuple[int, ...]:
        """(4, 4)."""
        return (4, 4)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(se3, 6, 16, 3)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rigid motion."""
        check_motion(name, g, 3)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """[[R^T, -R^T x], [0, 1]]."""
        return inverse_motion(g)

    def bracket(self, v: Array, w: Array) -> Array:
        """(v_r x w_r, v_r x w_t - w_r x v_t) for v = (v_r, v_t)."""
        turning = np.cross(v[:3], w[:3])
        return np.concatenate([turning, np.cross(v[:3], w[3:]) - np.cross(w[:3], v[3:])])
