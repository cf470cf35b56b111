"""Interfaces of charts: of a Lie group, and of the flow of a frame."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol


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
    """Coordinates that move with an integrable flow, see `galvi.frames.frame.Frame`."""

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'harmonic frame'."""

    @property
    def passes(self) -> int | None:
        """Passes of a step's iteration; None: as many as the tolerance needs."""
