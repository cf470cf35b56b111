"""Maps coordinates about the start of a step to configurations and velocities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Chart
from galvi.charts.maps import place, tangent
from galvi.groups.group import Group


class LocalChart(Protocol):
    """Coordinates xi (..., d) about base configurations; ``...`` are leading axes."""

    def place(self, base: Array, xi: Array) -> Array:
        """The configurations at xi about base (..., *shape)."""

    def velocity(self, xi: Callable[[], Array], rate: Array) -> Array:
        """The velocities for xi' = rate; xi is a function, which a vector space never calls."""


@dataclass(frozen=True)
class IdentityChart:
    """q = base + xi on a vector space; ``shape`` is that of one configuration."""

    shape: tuple[int, ...]

    def place(self, base: Array, xi: Array) -> Array:
        """base + xi, (..., *shape)."""
        return base + self._shaped(xi)

    def velocity(self, xi: Callable[[], Array], rate: Array) -> Array:
        """xi', (..., *shape)."""
        return self._shaped(rate)

    def _shaped(self, flat: Array) -> Array:
        return flat.reshape(*flat.shape[:-1], *self.shape)


@dataclass(frozen=True)
class GroupChart:
    """g = base Phi(xi) on a Lie group, with Phi the chart."""

    group: Group
    chart: Chart

    def place(self, base: Array, xi: Array) -> Array:
        """base Phi(xi), (..., *group.shape)."""
        return place(self.chart, self.group, base, xi)

    def velocity(self, xi: Callable[[], Array], rate: Array) -> Array:
        """The body velocity T(xi) xi', (..., d)."""
        result: Array = np.einsum("...ab,...b->...a", tangent(self.chart, self.group, xi()), rate)
        return result
