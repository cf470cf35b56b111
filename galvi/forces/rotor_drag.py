"""Drag in the wind below a rotor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from galvi import checks
from galvi.arrays import Array
from galvi.forces.known_force import Push
from galvi.kernels import rotor_wind


@dataclass(frozen=True)
class RotorDrag:
    """f = -factor |w| w, w = v - wind(q, t), q and v of shape (3,); M (14).

    factor  rho_air A C_d / 2 in kg/m, for the wind of galvi.kernels.rotor_wind in m/s; ValueError
            unless finite and positive
    """

    factor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "factor", checks.positive("factor", self.factor))

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        w = v - np.array(rotor_wind.rotor_wind(q[0], q[1], q[2], t))
        result: Array = -self.factor * np.sqrt(w @ w) * w
        return result

    def push(self) -> Push:
        """The same for the kernels."""
        return Push(rotor_wind.drag, np.array([self.factor]))
