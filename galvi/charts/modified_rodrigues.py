"""Modified Rodrigues parameters as a chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from galvi.kernels.lie.chart_functions import CHARTS
from galvi.kernels.lie.charts import modified_rodrigues


@dataclass(frozen=True)
class ModifiedRodrigues:
    """Cayley's map twice, Phi(xi) = ((I - hat(xi) / 4)^-1 (I + hat(xi) / 4))^2.

    |xi| = 4 tan(angle / 4). Rational, like Cayley's chart; a step must turn by less than a whole
    turn. Modified Rodrigues parameters are xi / 4.
    """

    number: ClassVar[int] = CHARTS.index(modified_rodrigues)
    limit: ClassVar[float] = modified_rodrigues.LIMIT
    farthest: ClassVar[float] = modified_rodrigues.FARTHEST
