"""Drag in the wind below a rotor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import rotor_wind
from galvi.systems.forces.drag_laws import DragLaw, QuadraticDrag, SchillerNaumann


@dataclass(frozen=True)
class RotorDrag:
    """f = -factor phi(|w|) w, w = v - wind(q, t), q and v of shape (3,).

    factor    for the wind of galvi.kernels.forces.rotor_wind in m/s, in the unit that the law
              states; ValueError unless finite and positive
    drag_law  phi: `QuadraticDrag`, which is M (14), or `SchillerNaumann`; TypeError for another
    """

    factor: float
    drag_law: DragLaw = field(default_factory=QuadraticDrag)

    def __post_init__(self) -> None:
        object.__setattr__(self, "factor", input_checks.positive("factor", self.factor))
        if not isinstance(self.drag_law, QuadraticDrag | SchillerNaumann):
            raise TypeError(
                f"drag_law must be galvi.QuadraticDrag() or galvi.SchillerNaumann(scale); received "
                f"{input_checks.shown(self.drag_law)}."
            )

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        w = v - np.array(rotor_wind.rotor_wind(q[0], q[1], q[2], t))
        result: Array = -self.factor * self.drag_law(np.sqrt(w @ w)) * w
        return result

    @property
    def law(self) -> str:
        """As `BuiltinForce.law`."""
        return f"from galvi.kernels.lanes.laws import {self.drag_law.name}_drag as force"

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinForce.compiled`, with the factor and the law's numbers for constants."""
        return self.drag_law.drag, np.array([self.factor, *self.drag_law.numbers])
