"""Rotations of space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Layout, one_factor
from galvi.groups.matrices import check_rotation
from galvi.kernels.lie.groups import so3


@dataclass(frozen=True)
class SO3:
    """Rotation matrices (3, 3) from the body's frame to space.

    Velocities (3,) are the body's angular velocity: R' = R hat(v), hat(v) w = v x w.
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
        return one_factor(so3, 3, 9, 3)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rotation of space."""
        check_rotation(name, g, 3)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """The transpose."""
        return np.swapaxes(g, -1, -2)

    def bracket(self, v: Array, w: Array) -> Array:
        """v x w."""
        return np.cross(v, w)
