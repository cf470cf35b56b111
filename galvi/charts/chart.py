"""What a chart of a group is: how far it reaches, and its number in the kernels."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol


class Chart(Hashable, Protocol):
    """A map Phi from the algebra to the group with Phi(0) = 1 and derivative 1 there (H 3.2.2)."""

    @property
    def number(self) -> int:
        """Its place in galvi.kernels.lie.chart_functions.CHARTS."""

    @property
    def limit(self) -> float:
        """The angle, radians, at which it or its tangent map becomes singular."""

    @property
    def farthest(self) -> float:
        """The largest |xi| of a rotation that a step may reach."""
