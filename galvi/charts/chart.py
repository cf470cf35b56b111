"""Charts of Lie groups: Cayley's, the exponential, and modified Rodrigues parameters."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar, Protocol

from galvi.kernels.lie.chart_functions import CHARTS
from galvi.kernels.lie.charts import cayley, exponential, modified_rodrigues


class Chart(Hashable, Protocol):
    """A map Phi from the algebra to the group with Phi(0) = 1 and derivative 1 there (H 3.2.2)."""

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'Cayley'."""

    @property
    def number(self) -> int:
        """Index in galvi.kernels.lie.chart_functions.CHARTS."""

    @property
    def limit(self) -> float:
        """The rotation angle, in radians, at which the map or its tangent becomes singular."""

    @property
    def farthest(self) -> float:
        """The largest |xi| of a rotation within a step."""


class MovingChart(Hashable, Protocol):
    """Coordinates that move with an integrable flow, see `galvi.fast.frames.frame.Frame`."""

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'harmonic frame'."""

    @property
    def passes(self) -> int | None:
        """Passes of a step's iteration; None: as many as the tolerance needs."""


@dataclass(frozen=True)
class Cayley:
    """Phi(xi) = (I - hat(xi) / 2)^-1 (I + hat(xi) / 2), |xi| = 2 tan(angle / 2) (H 3.4.2).

    Rational and therefore the fastest; a step must rotate by less than half a turn, the limit pi.
    H's xi is half of ours with the opposite sign.
    """

    name: ClassVar[str] = "Cayley"
    number: ClassVar[int] = CHARTS.index(cayley)
    limit: ClassVar[float] = cayley.LIMIT
    farthest: ClassVar[float] = cayley.FARTHEST


@dataclass(frozen=True)
class Exponential:
    """Phi(xi) = exp(hat(xi)), |xi| = angle; a step must rotate by less than 2 pi (claim L14)."""

    name: ClassVar[str] = "exponential"
    number: ClassVar[int] = CHARTS.index(exponential)
    limit: ClassVar[float] = exponential.LIMIT
    farthest: ClassVar[float] = exponential.FARTHEST


@dataclass(frozen=True)
class ModifiedRodrigues:
    """The Cayley transform squared, Phi(xi) = ((I - hat(xi) / 4)^-1 (I + hat(xi) / 4))^2.

    |xi| = 4 tan(angle / 4). Rational, like the Cayley chart; a step must rotate by less than 2 pi.
    The modified Rodrigues parameters are xi / 4 (Schaub and Junkins, J. Astronautical Sciences 44
    (1996) 1).
    """

    name: ClassVar[str] = "modified Rodrigues"
    number: ClassVar[int] = CHARTS.index(modified_rodrigues)
    limit: ClassVar[float] = modified_rodrigues.LIMIT
    farthest: ClassVar[float] = modified_rodrigues.FARTHEST
