"""The exponential map as a chart."""

from __future__ import annotations

import math
from dataclasses import dataclass

REACH = 0.995  # of the limit


@dataclass(frozen=True)
class Exponential:
    """Phi(xi) = exp(hat(xi)), |xi| = angle; a step must turn by less than a whole turn (L14)."""

    @property
    def number(self) -> int:
        """1."""
        return 1

    @property
    def limit(self) -> float:
        """2 pi, where the tangent map is singular."""
        return 2.0 * math.pi

    @property
    def farthest(self) -> float:
        """0.995 of the limit."""
        return REACH * self.limit
