"""The Galerkin curves of a run, in the inertial frame and in a moving frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import Chart, place, tangent
from galvi.groups.group import Group
from galvi.kernels.constants import COMPLEX_STEP, EPSILON
from galvi.spaces.space import Space


class LocalChart(Protocol):
    """Coordinates xi (..., d) about base configurations; ``...`` are leading axes."""

    def configurations(self, base: Array, xi: Array) -> Array:
        """The configurations at xi about base (..., *shape)."""

    def velocity(self, xi: Callable[[], Array], rate: Array) -> Array:
        """The velocities for xi' = rate; xi is a function, since vector spaces do not need it."""


@dataclass(frozen=True)
class IdentityChart:
    """q = base + xi on a vector space; ``shape`` is that of one configuration."""

    shape: tuple[int, ...]

    def configurations(self, base: Array, xi: Array) -> Array:
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

    def configurations(self, base: Array, xi: Array) -> Array:
        """base Phi(xi), (..., *group.shape)."""
        return place(self.chart, self.group, base, xi)

    def velocity(self, xi: Callable[[], Array], rate: Array) -> Array:
        """The body velocity T(xi) xi', (..., d)."""
        return np.einsum("...ab,...b->...a", tangent(self.chart, self.group, xi()), rate)


class CurvesOverTime:
    """Curves of steps of one length, evaluated at times; subclasses have ``positions`` and
    ``velocities`` of steps."""

    t0: float
    step: float
    coefficients: Array
    positions: Any
    velocities: Any

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        index, tau, is_scalar = locate_times(self.t0, self.step, self.coefficients, t)
        positions = self.positions(index, tau)
        return positions[0] if is_scalar else positions

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; where two steps meet, that of the later one.

        Raises
        ------
        ValueError
            Outside the run.
        """
        index, tau, single = locate_times(self.t0, self.step, self.coefficients, t)
        velocities = self.velocities(index, tau)
        return velocities[0] if single else velocities


@dataclass(frozen=True, eq=False)
class Curves(CurvesOverTime):
    """q(t_k + tau h) is at xi = sum_i coefficients[k, :, i] psi_i(tau) about base_k, 0 <= tau <= 1.

    Attributes
    ----------
    space
        psi_i are its basis functions after the constant, minus their values at 0
    t0, step
        start of the first curve and the length h of each
    bases : array, shape (steps, *shape)
        configuration at the start of each step
    coefficients : array, shape (steps, d, dimension - 1)
    chart
        maps xi to base + xi on a vector space, to base Phi(xi) on a Lie group

    Notes
    -----
    Steps that failed hold NaN.
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    chart: LocalChart

    def positions(self, index: Any, tau: Array) -> Array:
        """q (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self.chart.configurations(self.bases[index], self._coordinates(index, tau))

    def velocities(self, index: Any, tau: Array) -> Array:
        """dq/dt (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        slope = self.space.derivative(tau)[:, 1:]
        rate = np.einsum("kdi,ki->kd", self.coefficients[index], slope) / self.step
        return self.chart.velocity(lambda: self._coordinates(index, tau), rate)

    def _coordinates(self, index: Any, tau: Array) -> Array:
        """xi (k, d) at fractions tau (k,) of the steps ``index`` (k,)."""
        basis = self.space.basis(np.append(tau, 0.0))[:, 1:]
        return np.einsum("kdi,ki->kd", self.coefficients[index], basis[:-1] - basis[-1])


def times_as_array(t: Any) -> tuple[Array, bool]:
    """t as an array (k,), and whether it is a scalar; ValueError unless it is a scalar or (k,)."""
    times = input_checks.array("t", t)
    if times.ndim > 1:
        raise ValueError(f"t must be a scalar or of shape (k,); received shape {times.shape}.")
    return np.atleast_1d(times), times.ndim == 0


def refuse_outside(inside: Any, first: float, last: float, t: Any) -> None:
    """ValueError unless all entries of ``inside`` are true: t between ``first`` and ``last``."""
    if not np.all(inside):
        raise ValueError(
            f"t must lie inside the run, from {first!r} to {last!r}; received "
            f"{input_checks.shown(t)}."
        )


def locate_times(t0: float, step: float, coefficients: Array, t: Any) -> tuple[Any, Array, bool]:
    """Indices (k,) of the steps at times t, fractions (k,) of them in [0, 1], and whether t is a
    scalar; ValueError for a time outside the run."""
    times, single = times_as_array(t)
    count = len(coefficients)
    with np.errstate(over="ignore"):
        elapsed_steps = (times - t0) / step
    largest = max(abs(t0), abs(t0 + count * step)) / abs(step)
    slack = 4.0 * EPSILON * (largest + count) + 1e-14
    refuse_outside(
        (elapsed_steps >= -slack) & (elapsed_steps <= count + slack), t0, t0 + count * step, t
    )
    nearest_end = np.round(elapsed_steps)
    elapsed_steps = np.where(
        np.abs(elapsed_steps - nearest_end) <= slack, nearest_end, elapsed_steps
    )
    index = np.clip(np.floor(elapsed_steps).astype(np.intp), 0, count - 1)
    is_after_failure = (elapsed_steps == index) & np.isnan(coefficients[index, 0, 0]) & (index > 0)
    index = np.where(
        is_after_failure, index - 1, index
    )  # the last state before a failure ends its curve
    return index, elapsed_steps - index, single


@dataclass(frozen=True, eq=False)
class FrameCurves(CurvesOverTime):
    """q = phi_t(w) with w = base + sum_i coefficients[k, :, i] psi_i(c), t since a step's centre.

    Attributes
    ----------
    space
        psi_i are its basis functions after the constant, minus their values at 0
    t0, step
        start of the first curve and the length h of each
    bases : array, shape (steps, 4, m)
        the state in the frame before each step, and its low parts
    coefficients : array, shape (steps, 2 n, dimension - 1)
        n rows of positions and n of velocities; for a step that was done in the inertial frame all
        entries but the first are NaN, and its base holds q and v
    first
        number of steps from the problem's start to the first curve
    path
        the frame, a `galvi.run.in_frame.curves.FrameOfRun`
    """

    space: Space
    t0: float
    step: float
    bases: Array
    coefficients: Array
    first: int
    path: Any

    def positions(self, index: Any, tau: Array) -> Array:
        """q (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self._in_both_frames(index, tau, self._frame_positions, Curves.position)

    def velocities(self, index: Any, tau: Array) -> Array:
        """dq/dt (k, ...) at fractions tau (k,) of the steps ``index`` (k,)."""
        return self._in_both_frames(index, tau, self._frame_velocities, Curves.velocity)

    def _in_both_frames(self, index: Any, tau: Array, in_frame: Any, inertial: Any) -> Array:
        """Values (k, ...) by ``in_frame``, or by ``inertial`` for steps done in the inertial
        frame."""
        is_inertial = np.isnan(self.coefficients[index, -1, -1]) & ~np.isnan(
            self.bases[index, 0, 0]
        )
        rows, values = (
            [np.flatnonzero(~is_inertial)],
            [in_frame(index[~is_inertial], tau[~is_inertial])],
        )
        for k in np.unique(index[is_inertial]).tolist():
            rows.append(np.flatnonzero(is_inertial & (index == k)))
            curves = self.path.curves(self.first + k, self.bases[k])
            values.append(inertial(curves, tau[rows[-1]] * self.step))
        return np.concatenate(values)[np.argsort(np.concatenate(rows))]

    def _frame_positions(self, index: Any, tau: Array) -> Array:
        w, _rate, since = self._frame_states(index, tau)
        return self.path.flow(w, since)

    def _frame_velocities(self, index: Any, tau: Array) -> Array:
        w, rate, since = self._frame_states(index, tau)
        moved = self.path.flow(w + 1j * COMPLEX_STEP * rate, since + 1j * COMPLEX_STEP)
        return np.imag(moved) / COMPLEX_STEP

    def _frame_states(self, index: Any, tau: Array) -> tuple[Array, Array, Array]:
        """w (k, 4, m), dw/dt, and the times (k,) since the steps' centres."""
        c, slope = self.path.node(self.first + index, tau)
        basis = self.space.basis(np.append(c, 0.0))[:, 1:]
        displacements = np.einsum("kdi,ki->kd", self.coefficients[index], basis[:-1] - basis[-1])
        rates = np.einsum("kdi,ki->kd", self.coefficients[index], self.space.derivative(c)[:, 1:])
        w, rate = self.bases[index].copy(), np.zeros_like(self.bases[index])
        n = displacements.shape[1] // 2
        w[:, :2, :n] += displacements.reshape(-1, 2, n)
        rate[:, :2, :n] = (rates * (slope / self.step)[:, None]).reshape(-1, 2, n)
        return w, rate, (tau - 0.5) * self.step
