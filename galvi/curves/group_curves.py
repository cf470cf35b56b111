"""The Galerkin curves of a run on a group."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import Chart
from galvi.charts.maps import place, tangent
from galvi.curves.vector_curves import Pieces
from galvi.groups.group import Group
from galvi.spaces.space import Space


@dataclass(frozen=True, eq=False)
class GroupCurves:
    """q(t_k + tau h) = base_k Phi(xi), xi = sum_i coefficients[k, :, i] psi_i(tau).

    space, t0, step, coefficients  as in `galvi.curves.vector_curves.Curves`
    bases                          (steps, *group.shape) configuration at the start of each step
    group, chart                   where the curves live, and Phi
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    group: Group
    chart: Chart

    def position(self, t: Any) -> Array:
        """q at t: group.shape for a scalar, (k, ...) for (k,). ValueError outside the run."""
        index, xi, _, single = self._in_chart(t)
        places = place(self.chart, self.group, self.bases[index], xi)
        return places[0] if single else places

    def velocity(self, t: Any) -> Array:
        """Body velocity T(xi) xi' at t; at a joint, the later step's. Errors as ``position``."""
        _, xi, rate, single = self._in_chart(t)
        velocities = np.einsum("kab,kb->ka", tangent(self.chart, self.group, xi), rate)
        return velocities[0] if single else velocities

    def _in_chart(self, t: Any) -> tuple[Any, Array, Array, bool]:
        """Step, xi (k, d) and xi' (k, d) at t, and whether t is a scalar."""
        index, tau, single = Pieces(self.t0, self.step, self.coefficients).locate(t)
        basis = self.space.basis(tau)[:, 1:] - self.space.basis(np.zeros(1))[:, 1:]
        slope = self.space.derivative(tau)[:, 1:]
        chosen = self.coefficients[index]
        xi = np.einsum("kdi,ki->kd", chosen, basis)
        return index, xi, np.einsum("kdi,ki->kd", chosen, slope) / self.step, single
