"""Interface of Lie groups of matrices or vectors."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.kernels.lie.product import GROUPS

Layout = npt.NDArray[np.int64]


class Group(Hashable, Protocol):
    """A group; its elements are arrays of ``shape``, its algebra is R^dimension.

    Velocities and momenta are left-trivialised: g' = g hat(v), and mu is dual to v.
    """

    @property
    def dimension(self) -> int:
        """Dimension d of the group and of its algebra."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one element."""

    @property
    def layout(self) -> Layout:
        """(factors, 4): number of each factor's group in the kernels, its dimension, entries and
        rotations; see galvi.kernels.lie.product."""

    def check(self, name: str, g: Array) -> None:
        """Raise ValueError unless g is an element of the group to within 1e-9."""

    def multiply(self, g: Array, k: Array) -> Array:
        """g k, for elements with any leading axes."""

    def inverse(self, g: Array) -> Array:
        """g^-1, for elements with any leading axes."""

    def bracket(self, v: Array, w: Array) -> Array:
        """[v, w] in the algebra, (d,): hat([v, w]) = hat(v) hat(w) - hat(w) hat(v)."""


def one_factor(kernel: Any, dimension: int, entries: int, rotations: int) -> Layout:
    """The layout of a group that is not a product.

    kernel     its module of galvi.kernels.lie.groups
    entries    number of entries of one element
    rotations  number of leading components of a velocity that are rotations
    """
    return np.array([[GROUPS.index(kernel), dimension, entries, rotations]])


def is_group(value: Any) -> bool:
    """Whether the value is a group, not a class of groups."""
    return hasattr(value, "layout") and not isinstance(value, type)
