"""The Galerkin curves of a run: dense output that is part of the method, not an interpolant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.curves.local_chart import LocalChart
from galvi.spaces.space import Space

EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Curves:
    """q(t_k + tau h) is at xi = sum_i coefficients[k, :, i] psi_i(tau) about base_k, 0 <= tau <= 1.

    space         psi_i are its basis functions after the constant, minus their values at 0
    t0, step      start of the first curve and the length h of each
    bases         (steps, *shape) configuration at the start of each step
    coefficients  (steps, d, dimension - 1)
    chart         maps xi to base + xi on a vector space, to base Phi(xi) on a Lie group

    Steps that failed hold NaN.
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    chart: LocalChart

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        index, tau, single = located(self.t0, self.step, self.coefficients, t)
        places = self.places(index, tau)
        return places[0] if single else places

    def places(self, index: Any, tau: Array) -> Array:
        """q (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self.chart.place(self.bases[index], self._coordinates(index, tau))

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; where two steps meet, that of the later one.

        ValueError outside the run.
        """
        index, tau, single = located(self.t0, self.step, self.coefficients, t)
        velocities = self.velocities(index, tau)
        return velocities[0] if single else velocities

    def velocities(self, index: Any, tau: Array) -> Array:
        """dq/dt (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        slope = self.space.derivative(tau)[:, 1:]
        rate = np.einsum("kdi,ki->kd", self.coefficients[index], slope) / self.step
        return self.chart.velocity(lambda: self._coordinates(index, tau), rate)

    def _coordinates(self, index: Any, tau: Array) -> Array:
        """xi (k, d) at places tau (k,) of the steps ``index`` (k,)."""
        basis = self.space.basis(np.append(tau, 0.0))[:, 1:]
        xi: Array = np.einsum("kdi,ki->kd", self.coefficients[index], basis[:-1] - basis[-1])
        return xi


def located(t0: float, step: float, coefficients: Array, t: Any) -> tuple[Any, Array, bool]:
    """Index of the step (k,), fraction of it (k,) in [0, 1], and whether t is a scalar."""
    times = input_checks.array("t", t)
    if times.ndim > 1:
        raise ValueError(f"t must be a scalar or of shape (k,); received shape {times.shape}.")
    count = len(coefficients)
    with np.errstate(over="ignore"):
        place = (np.atleast_1d(times) - t0) / step
    largest = max(abs(t0), abs(t0 + count * step)) / abs(step)
    slack = 4.0 * EPSILON * (largest + count) + 1e-14
    if not np.all((place >= -slack) & (place <= count + slack)):
        last = t0 + count * step
        raise ValueError(
            f"t must lie inside the run, from {t0!r} to {last!r}; received {input_checks.shown(t)}."
        )
    joint = np.round(place)
    place = np.where(np.abs(place - joint) <= slack, joint, place)
    index = np.clip(np.floor(place).astype(np.intp), 0, count - 1)
    past = (place == index) & np.isnan(coefficients[index, 0, 0]) & (index > 0)
    index = np.where(past, index - 1, index)  # the last state before a failure ends its curve
    return index, place - index, times.ndim == 0
