"""Drag in the wind below a rotor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import rotor_wind


@dataclass(frozen=True)
class RotorDrag:
    """f = -factor |w| w, w = v - wind(q, t), q and v of shape (3,); M (14).

    factor  rho_air A C_d / 2 in kg/m, for the wind of galvi.kernels.forces.rotor_wind in m/s;
            ValueError unless finite and positive
    """

    factor: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "factor", input_checks.positive("factor", self.factor))

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        w = v - np.array(rotor_wind.rotor_wind(q[0], q[1], q[2], t))
        result: Array = -self.factor * np.sqrt(w @ w) * w
        return result

    @property
    def law(self) -> str:
        """As `BuiltinForce.law`."""
        return "from galvi.kernels.lanes.laws import rotor_drag as force"

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinForce.compiled`, with (factor,) for constants."""
        return rotor_wind.drag, np.array([self.factor])
