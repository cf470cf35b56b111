"""The curves of a run in a clock, q and t over tau, and so q over t; and those of a run that
actions changed, one after another, each with steps of its own."""

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

TIME_ITERATIONS = 60  # of a bracketed Newton iteration
GROWTH_SAMPLES = 9  # places of a step at which the growth of t is checked


@dataclass(frozen=True, eq=False)
class ClockCurves:
    """q and t at shares x of steps in tau; t(x) has the slopes h g at the stages.

    Attributes
    ----------
    method
        with its clock
    step
        length h of all steps but the last in tau
    last
        length of the last step in tau
    times : array, shape (steps + 1,)
        t between the steps
    bases : array, shape (steps, *shape)
        configurations there
    coefficients : array, shape (steps, d, m)
        as of `galvi.curves.curves.Curves`
    rates : array, shape (steps, s)
        g at the stages
    chart
        of the coefficients
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
        """Numbers of the steps in which t does not grow, at some of their places."""
        rates = self.rates @ _to_samples(self.method.table)
        return np.flatnonzero((rates <= 0.0).any(axis=1))

    @property
    def _curves(self) -> Curves:
        """In tau, where each step has the length 1."""
        return Curves(self.method.space, 0.0, 1.0, self.bases, self.coefficients, self.chart)

    def _time(self, index: Any, x: Array) -> tuple[Array, Array]:
        """t - the start of the step, and dt/dx, at shares x (k,) of the steps ``index`` (k,)."""
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
        """The shares of the steps at times since their starts."""
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
    """(s, TIME_PLACES) from the values at the stages of a step to those at even places of it."""
    legendres = legendre.legvander(np.linspace(-1.0, 1.0, GROWTH_SAMPLES), len(table.analysis) - 1)
    return read_only((legendres @ table.analysis).T)


def _row_products(basis: Any, series: Any) -> Array:
    return np.einsum("kl,lk->k", basis, series)


@dataclass(frozen=True, eq=False)
class JoinedCurves:
    """Curves of a run's parts, as `galvi.curves.curves.Curves` or another kind.

    Attributes
    ----------
    times : array, shape (parts + 1,)
        limits of the parts
    parts
        the curves; that of a part's last step may go on beyond its limit
    """

    times: Array
    parts: tuple[Any, ...]

    def position(self, t: Any) -> Array:
        """q at t: its shape for a scalar t, (k, ...) for (k,). ValueError outside the run."""
        return self._at_times(t, "position")

    def velocity(self, t: Any) -> Array:
        """dq/dt at t, on a group the body velocity; at an action that after it."""
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
    """Consecutive curves as one."""
    names = ("bases", "coefficients", "rates")[: 3 if isinstance(parts[0], ClockCurves) else 2]
    merged_fields: dict[str, Any] = {
        name: read_only(np.concatenate([getattr(part, name) for part in parts])) for name in names
    }
    if isinstance(parts[0], ClockCurves):
        times = [parts[0].times, *(part.times[1:] for part in parts[1:])]
        merged_fields |= {"times": read_only(np.concatenate(times)), "last": parts[-1].last}
    return replace(parts[0], **merged_fields)
