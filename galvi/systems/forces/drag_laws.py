"""How the drag of a sphere depends on its speed in the air."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from galvi import input_checks
from galvi.kernels.forces import rotor_wind


class DragLaw(Protocol):
    """phi in f = -factor phi(|w|) w."""

    def __call__(self, speed: float) -> float:
        """phi at |w|."""

    @property
    def numbers(self) -> tuple[float, ...]:
        """Its numbers, which follow the factor in the constants of kernels."""

    @property
    def name(self) -> str:
        """Its function in galvi.kernels.lanes.laws."""

    @property
    def drag(self) -> Callable[..., Any]:
        """Its function in galvi.kernels.forces.rotor_wind."""


@dataclass(frozen=True)
class QuadraticDrag:
    """phi = |w|: a constant drag coefficient C_d, with factor = rho_air A C_d / 2 in kg/m."""

    numbers = ()
    name = "quadratic"
    drag = staticmethod(rotor_wind.quadratic_drag)

    def __call__(self, speed: float) -> float:
        """phi at |w| in m/s."""
        return speed


@dataclass(frozen=True)
class SchillerNaumann:
    """phi = 1 + 0.15 Re^0.687, Re = scale |w|, with factor = 3 pi mu d in kg/s, Stokes' drag.

    C_d = 24 / Re (1 + 0.15 Re^0.687) is within 5 % of the measured one of a sphere up to Re = 1000
    (Schiller and Naumann, Z. VDI 77 (1933) 318; Clift, Grace and Weber, Bubbles, Drops, and
    Particles (1978), table 5.1). Above, it is not changed to a constant.

    scale  rho_air d / mu in s/m; ValueError unless finite and positive
    """

    scale: float
    name = "schiller_naumann"
    drag = staticmethod(rotor_wind.schiller_naumann_drag)

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", input_checks.positive("scale", self.scale))

    @property
    def numbers(self) -> tuple[float, ...]:
        """(scale,)."""
        return (self.scale,)

    def __call__(self, speed: float) -> float:
        """phi at |w| in m/s."""
        re = self.scale * speed
        return 1.0 + rotor_wind.INERTIA * float(re**rotor_wind.INERTIA_POWER)
