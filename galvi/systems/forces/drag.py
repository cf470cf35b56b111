"""Drag of a grain in air, and in the wind below a rotor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.kernels.forces import rotor_wind


class DragLaw:
    """phi in f = -factor phi(|w|) w.

    Attributes
    ----------
    rate
        function of galvi.kernels.forces.rotor_wind that returns factor phi
    numbers
        parameters of phi, which follow the factor in the constants
    """

    rate: ClassVar[Callable[..., Any]]
    numbers: Any

    def __call__(self, speed: Any) -> Any:
        """phi at |w| in m/s."""
        return self.rate(np.square(speed), (1.0, *self.numbers))[0]


@dataclass(frozen=True)
class QuadraticDrag(DragLaw):
    """``phi = |w|``: a constant drag coefficient C_d, with factor = rho_air A C_d / 2 in kg/m.

    Examples
    --------
    >>> galvi.RotorDrag(1e-8).drag_law == galvi.QuadraticDrag()
    True
    """

    rate = staticmethod(rotor_wind.quadratic)
    numbers = ()


@dataclass(frozen=True)
class SchillerNaumann(DragLaw):
    """phi = 1 + 0.15 Re^0.687, ``Re = scale |w|``, with factor = 3 pi mu d in kg/s, Stokes' drag.

    C_d = 24 / Re (1 + 0.15 Re^0.687) is within 5 % of that measured for spheres up to Re = 1000
    (Schiller and Naumann, Z. VDI 77 (1933) 318; Clift, Grace and Weber, Bubbles, Drops, and
    Particles (1978), table 5.1). The formula is used beyond Re = 1000 too.

    Parameters
    ----------
    scale
        rho_air d / mu in s/m; ValueError unless finite and positive

    Examples
    --------
    >>> law = galvi.SchillerNaumann(scale=6.6)  # rho_air d / mu of 100 micrometres
    >>> galvi.RotorDrag(factor=1.7e-8, drag_law=law).drag_law.scale
    6.6
    """

    rate = staticmethod(rotor_wind.schiller_naumann)
    scale: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", input_checks.positive("scale", self.scale))

    @property
    def numbers(self) -> tuple[float, ...]:
        """(scale,)."""
        return (self.scale,)


@dataclass(frozen=True)
class RotorDrag:
    """``f = -factor phi(|w|) w``, w = v - wind(q, t), q and v of shape (3,).

    Parameters
    ----------
    factor
        in the unit that the drag law states, for the wind of galvi.kernels.forces.rotor_wind in
        m/s; ValueError unless finite and positive
    drag_law
        phi: `QuadraticDrag`, which is M (14), or `SchillerNaumann`; TypeError for another

    Examples
    --------
    >>> drag = galvi.RotorDrag(factor=1e-8, drag_law=galvi.QuadraticDrag())
    >>> drag(np.array([8.5, 0.0, 3.0]), np.array([0.0, 1.0, 0.0]), 0.0).shape
    (3,)
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
        return np.array(rotor_wind.drag_of(self.drag_law.rate)(q, v, t, self.constants))

    @property
    def constants(self) -> Array:
        """The factor and the law's numbers."""
        return np.array([self.factor, *self.drag_law.numbers])

    def compiled(self) -> tuple[Callable[..., Any], Array]:
        """As `BuiltinForce.compiled`."""
        return rotor_wind.drag_kernel(self.drag_law.rate), self.constants
