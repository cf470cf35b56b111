"""The vector space R^d as a group under addition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.group import Layout, one_factor
from galvi.kernels.lie.groups import rn


@dataclass(frozen=True)
class Rn:
    """R^n; elements and velocities have shape (n,). ValueError unless n is at least 1."""

    n: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "n", input_checks.whole("n", self.n))

    @property
    def dimension(self) -> int:
        """n."""
        return self.n

    @property
    def shape(self) -> tuple[int, ...]:
        """(n,)."""
        return (self.n,)

    @property
    def layout(self) -> Layout:
        """One factor."""
        return one_factor(rn, self.n, self.n, 0)

    def check(self, name: str, g: Array) -> None:
        """ValueError unless g is (n,)."""
        if g.shape != self.shape:
            raise ValueError(f"{name} must have shape {self.shape}; received shape {g.shape}.")

    def multiply(self, g: Array, k: Array) -> Array:
        """g + k."""
        return g + k

    def inverse(self, g: Array) -> Array:
        """-g."""
        return -g

    def bracket(self, v: Array, w: Array) -> Array:
        """Zero."""
        return np.zeros(self.n)
