"""Modified Rodrigues parameters as a chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from galvi.kernels.lie.chart_functions import CHARTS
from galvi.kernels.lie.charts import modified_rodrigues


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
