"""The Cayley transform as a chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from galvi.kernels.lie.chart_functions import CHARTS
from galvi.kernels.lie.charts import cayley


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
