"""The exponential map as a chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from galvi.kernels.lie.chart_functions import CHARTS
from galvi.kernels.lie.charts import exponential


@dataclass(frozen=True)
class Exponential:
    """Phi(xi) = exp(hat(xi)), |xi| = angle; a step must rotate by less than 2 pi (claim L14)."""

    name: ClassVar[str] = "exponential"
    number: ClassVar[int] = CHARTS.index(exponential)
    limit: ClassVar[float] = exponential.LIMIT
    farthest: ClassVar[float] = exponential.FARTHEST
