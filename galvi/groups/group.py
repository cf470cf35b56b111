"""What the rest of the package asks of a Lie group of matrices or vectors."""

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
        """Of the group and of its algebra."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Of one element."""

    @property
    def layout(self) -> Layout:
        """(factors, 4): each factor's group, dimension, entries and rotations, as of
        galvi.kernels.lie.product."""

    def check(self, name: str, g: Array) -> None:
        """ValueError, in one sentence, unless g is an element to within 1e-9."""

    def multiply(self, g: Array, k: Array) -> Array:
        """g k, for elements with any leading axes."""

    def inverse(self, g: Array) -> Array:
        """g^-1, for elements with any leading axes."""

    def bracket(self, v: Array, w: Array) -> Array:
        """[v, w] in the algebra, (d,): hat([v, w]) = hat(v) hat(w) - hat(w) hat(v)."""


def one_factor(kernel: Any, dimension: int, entries: int, rotations: int) -> Layout:
    """The layout of a group that is no product.

    kernel     its module of galvi.kernels.lie.groups
    entries    of one element
    rotations  how many components of a velocity are rotations; they come first
    """
    return np.array([[GROUPS.index(kernel), dimension, entries, rotations]])


def is_group(value: Any) -> bool:
    """Whether it is a group, and not the class of one."""
    return hasattr(value, "layout") and not isinstance(value, type)
