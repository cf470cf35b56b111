"""The gravitational potential of a rigid body that rotates about a fixed point."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array


@dataclass(frozen=True, eq=False)
class UniformGravity:
    """V(R) = -mass g . R centre, R of shape (3, 3).

    mass    of the body, positive
    centre  (3,) of mass, from the fixed point, in the body's frame
    g       (3,) acceleration of gravity in space; a number g stands for (0, 0, -g), downwards

    Raises ValueError for a mass that is not positive, a wrong shape or a number that is not finite.
    """

    mass: float
    centre: Any
    g: Any = 9.81

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", input_checks.positive("mass", self.mass))
        object.__setattr__(self, "centre", input_checks.array("centre", self.centre, (3,)))
        g = self.g
        if not isinstance(g, Iterable) or isinstance(g, str):
            g = [0.0, 0.0, -input_checks.real("g", g, "Give a number, or a vector (3,) in space.")]
        object.__setattr__(self, "g", input_checks.array("g", g, (3,)))

    def __reduce__(self) -> tuple[Any, ...]:
        return UniformGravity, (self.mass, self.centre, self.g)

    def __call__(self, R: Array) -> Any:
        return -self.mass * ((self.g @ R) @ self.centre)

    def gradient(self, R: Array) -> Array:
        """dV/dR = -mass g centre^T, (3, 3)."""
        return -self.mass * np.outer(self.g, self.centre)

    @property
    def numbers(self) -> Array:
        """(6,): mass g, then the centre, the constants of the compiled form."""
        return np.concatenate([self.mass * self.g, self.centre])
