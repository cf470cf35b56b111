"""Rotations of the plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Layout, one_factor
from galvi.groups.matrices import check_rotation
from galvi.kernels.lie.groups import so2


@dataclass(frozen=True)
class SO2:
    """Rotation matrices (2, 2); velocities (1,), R' = R [[0, -v], [v, 0]]."""

    @property
    def dimension(self) -> int:
        """1."""
        return 1

    @property
    def shape(self) -> tuple[int, ...]:
        """(2, 2)."""
        return (2, 2)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(so2, 1, 4, 1)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is a rotation of the plane."""
        check_rotation(name, g, 2)

    def multiply(self, g: Array, k: Array) -> Array:
        """The matrix product."""
        return g @ k

    def inverse(self, g: Array) -> Array:
        """The transpose."""
        return np.swapaxes(g, -1, -2)

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero: rotations of the plane commute."""
        return np.zeros(1)
