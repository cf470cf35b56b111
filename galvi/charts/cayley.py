"""The Cayley transform as a chart."""

from __future__ import annotations

import math
from dataclasses import dataclass

REACH = 0.995  # of the limit


@dataclass(frozen=True)
class Cayley:
    """Phi(xi) = (I - hat(xi) / 2)^-1 (I + hat(xi) / 2), |xi| = 2 tan(angle / 2) (H 3.4.2).

    Rational, and so the fastest; a step must turn by less than half a turn. H's xi is half of ours
    with the opposite sign.
    """

    @property
    def number(self) -> int:
        """0."""
        return 0

    @property
    def limit(self) -> float:
        """pi, where |xi| is infinite."""
        return math.pi

    @property
    def farthest(self) -> float:
        """|xi| at 0.995 pi."""
        return 2.0 * math.tan(0.5 * REACH * math.pi)
