"""The curves of a run in a clock, which has q and t as functions of tau, and the joined curves of a
run that actions changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from galvi.arrays import Array, read_only
from galvi.curves.curves import (
    Curves,
    LocalChart,
    refuse_outside,
    times_as_array,
)
from galvi.kernels.constants import EPSILON
from galvi.method import Galerkin
from galvi.tableau import Tableau

TIME_ITERATIONS = 60  # largest number of bracketed Newton iterations for tau at a time
GROWTH_SAMPLES = 9  # points of a step at which the growth of t is checked


@dataclass(frozen=True, eq=False)
class ClockCurves:
    """q and t at fractions x of steps in tau; t(x) has the slopes h g at the stages.

    Attributes
    ----------
    method
        the method, with its clock
    step
        length in tau, h, of all steps but the last
    last
        length in tau of the last step
    times : array, shape (steps + 1,)
        t at the start of each step and at the end of the last
    bases : array, shape (steps, *shape)
        configurations at the starts of the steps
    coefficients : array, shape (steps, d, m)
        see `galvi.curves.curves.Curves`
    rates : array, shape (steps, s)
        g at the stages
    chart
        see `galvi.curves.curves.Curves`
    """

    method: Galerkin
    step: float
    last: float
    times: Array
    bases: Array
    coefficients: Array
    rates: Array
    chart: LocalChart

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        return self._at(t, lambda index, x: self._curves.positions(index, x))

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; where steps meet, that of the later one."""

        def velocities(index: Any, x: Array) -> Array:
            slopes = self._curves.velocities(index, x)
            rate = self._time(index, x)[1]
            return slopes / rate.reshape(-1, *(1,) * (slopes.ndim - 1))

        return self._at(t, velocities)

    def steps_backwards(self) -> Any:
        """Indices of the steps in which dt/dtau is not positive at one of GROWTH_SAMPLES points."""
        rates = self.rates @ _to_samples(self.method.table)
        return np.flatnonzero((rates <= 0.0).any(axis=1))

    @property
    def _curves(self) -> Curves:
        """The curves over tau / h, in which each step has the length 1."""
        return Curves(self.method.space, 0.0, 1.0, self.bases, self.coefficients, self.chart)

    def _time(self, index: Any, x: Array) -> tuple[Array, Array]:
        """The times since the starts of the steps ``index`` (k,), and dt/dx, at fractions x
        (k,)."""
        lengths = np.full(len(self.rates), self.step)
        lengths[-1:] = self.last
        series = (self.method.table.analysis @ self.rates[index].T) * lengths[index]
        rates = _row_products(legendre.legvander(2.0 * x - 1.0, len(series) - 1), series)
        integrated = legendre.legint(series, lbnd=-1.0, axis=0)
        return 0.5 * _row_products(
            legendre.legvander(2.0 * x - 1.0, len(integrated) - 1), integrated
        ), rates

    def _at(self, t: Any, values: Callable[[Any, Array], Array]) -> Array:
        times, is_scalar = times_as_array(t)
        sign = 1.0 if self.step > 0.0 else -1.0
        signed_grid, signed_times = sign * self.times, sign * times
        slack = 8.0 * EPSILON * max(abs(signed_grid[0]), abs(signed_grid[-1]))
        inside = (signed_times >= signed_grid[0] - slack) & (
            signed_times <= signed_grid[-1] + slack
        )
        refuse_outside(inside, float(self.times[0]), float(self.times[-1]), t)
        index = np.clip(
            np.searchsorted(signed_grid, signed_times, side="right") - 1, 0, len(signed_grid) - 2
        )
        since = sign * (signed_times - signed_grid[index])
        rows = values(index, self._fractions(index, since))
        return rows[0] if is_scalar else rows

    def _fractions(self, index: Any, since: Array) -> Array:
        """The fractions x (k,) of the steps ``index`` (k,) at times (k,) since their starts."""
        lengths = self.times[index + 1] - self.times[index]
        x = np.clip(since / lengths, 0.0, 1.0)
        low, high = np.zeros_like(x), np.ones_like(x)
        for _ in range(TIME_ITERATIONS):
            t, rate = self._time(index, x)
            remaining = (since - t) * np.sign(lengths)
            low, high = np.where(remaining > 0.0, x, low), np.where(remaining > 0.0, high, x)
            with np.errstate(divide="ignore", invalid="ignore"):
                new_x = x + (since - t) / rate
            new_x = np.where((new_x >= low) & (new_x <= high), new_x, 0.5 * (low + high))
            if np.all(np.abs(new_x - x) <= EPSILON):
                break
            x = new_x
        is_end = (since == 0.0) | (since == lengths)
        return np.where(is_end, np.where(since == 0.0, 0.0, 1.0), x)


@lru_cache(maxsize=32)
def _to_samples(table: Tableau) -> Array:
    """The matrix (s, GROWTH_SAMPLES) from values at the stages of a step to values at evenly spaced
    points of it."""
    legendres = legendre.legvander(np.linspace(-1.0, 1.0, GROWTH_SAMPLES), len(table.analysis) - 1)
    return read_only((legendres @ table.analysis).T)


def _row_products(basis: Any, series: Any) -> Array:
    return np.einsum("kl,lk->k", basis, series)


@dataclass(frozen=True, eq=False)
class JoinedCurves:
    """The curves of the parts of a run.

    Attributes
    ----------
    times : array, shape (parts + 1,)
        times at which the parts begin and the last one ends
    parts
        `Curves`, `FrameCurves` or `ClockCurves` of each part; their last step may end after the
        part
    """

    times: Array
    parts: tuple[Any, ...]

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        return self._at_times(t, "position")

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; at the time of an action, that after it."""
        return self._at_times(t, "velocity")

    def _at_times(self, t: Any, name: str) -> Array:
        times, single = times_as_array(t)
        sign = 1.0 if self.times[-1] > self.times[0] else -1.0
        grid, wanted = sign * self.times, times
        inside = (sign * wanted >= grid[0]) & (sign * wanted <= grid[-1])
        refuse_outside(inside, float(self.times[0]), float(self.times[-1]), t)
        index = np.searchsorted(grid, sign * wanted, side="right") - 1
        index = np.minimum(index, len(self.parts) - 1)
        order = np.argsort(index, kind="stable")
        piece_starts = np.flatnonzero(np.diff(index[order])) + 1
        pieces = [
            getattr(self.parts[index[rows[0]]], name)(wanted[rows])
            for rows in np.split(order, piece_starts)
            if rows.size
        ]
        values: Array = np.concatenate(pieces)[np.argsort(order)] if pieces else np.zeros(0)
        return values[0] if single else values


def first_steps(curves: Any, n: int) -> Any:
    """The curves of the first n steps."""
    if n == len(curves.bases):
        return curves
    parts = {"bases": curves.bases[:n], "coefficients": curves.coefficients[:n]}
    if isinstance(curves, ClockCurves):
        parts |= {"times": curves.times[: n + 1], "rates": curves.rates[:n], "last": curves.step}
    return replace(curves, **parts)


def merge_curves(parts: list[Any]) -> Any:
    """The curves of consecutive steps as one value."""
    names = ("bases", "coefficients", "rates")[: 3 if isinstance(parts[0], ClockCurves) else 2]
    merged_fields: dict[str, Any] = {
        name: read_only(np.concatenate([getattr(part, name) for part in parts])) for name in names
    }
    if isinstance(parts[0], ClockCurves):
        times = [parts[0].times, *(part.times[1:] for part in parts[1:])]
        merged_fields |= {"times": read_only(np.concatenate(times)), "last": parts[-1].last}
    return replace(parts[0], **merged_fields)
