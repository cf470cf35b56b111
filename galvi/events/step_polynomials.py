"""The coordinates and the time of many steps, as polynomials of one variable on each of them.

That is the fraction of a step in time, in a clock the fraction of the step in tau, and in a frame
the place among its nodes, from 0 to 1. In a frame places are not polynomials: they are interpolated
at Chebyshev points, more until the last coefficients are small.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre

from galvi.arrays import Array
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import Curves, FrameCurves, IdentityChart
from galvi.events.roots import points_of, times_matrix
from galvi.kernels.curve_bounds import compiled_curve_bounds
from galvi.spaces.polynomials import ComponentPolynomials, Polynomials

# In a frame, one after the other: with x the fraction in time or the place among nodes, to which
# eccentric orbits are smooth, at so many points.
INTERPOLATIONS = ((False, 11), (True, 24), (True, 48))
SMOOTH = 1e-10  # last coefficients of a body's places, relative to the largest, that are small
STEPS_TOGETHER = 1024  # steps in a frame that are interpolated at once

Later = Callable[[int], Array]


@dataclass(frozen=True)
class Chebyshev:
    """T_0 to T_(n-1) on [0, 1], with the ``basis`` and ``derivative`` of a `galvi.Space`."""

    dimension: int

    def basis(self, x: Array) -> Array:
        """(k, n) at x (k,)."""
        return chebyshev.chebvander(2.0 * x - 1.0, self.dimension - 1).astype(np.float64)

    def derivative(self, x: Array) -> Array:
        """By x, (k, n)."""
        slopes = chebyshev.chebder(np.eye(self.dimension), axis=0, scl=2.0)
        return chebyshev.chebvander(2.0 * x - 1.0, self.dimension - 2) @ slopes


class StepPolynomials(NamedTuple):
    """n steps, with x the variable, from 0 to 1.

    Attributes
    ----------
    space
        psi_i are its basis functions after the constant, minus their values at 0
    bases : array, shape (n, d)
        coordinates at x = 0
    coefficients : array, shape (n, d, m)
        of psi_i in them
    begin : array, shape (n,)
        the times at x = 0
    lapses : array, shape (n, l)
        Chebyshev coefficients of the times since then
    lengths : array, shape (n,)
        of the steps, in time
    rough : array, shape (n,)
        whether a step has no such polynomials
    bounded
        whether ``space`` is one of polynomials
    """

    space: Any
    bases: Array
    coefficients: Array
    begin: Array
    lapses: Array
    lengths: Array
    rough: Any
    bounded: bool

    @property
    def even(self) -> bool:
        """Whether times are linear in x."""
        return self.lapses.shape[1] == 2

    def times(self, rows: Any, x: Array) -> tuple[Array, Array]:
        """The times at x (k,) of the steps ``rows`` (k,), which are not even, and dt/dx."""
        series, y = self.lapses[rows], 2.0 * x - 1.0
        values = chebyshev.chebvander(y, series.shape[1] - 1)
        slopes = chebyshev.chebvander(y, series.shape[1] - 2)
        rates = chebyshev.chebder(series, axis=1, scl=2.0)
        t = self.begin[rows] + np.sum(values * series, axis=1)
        return t, np.sum(slopes * rates, axis=1)

    def at_points(self, rows: Any, points: int) -> tuple[Later, Later, Array]:
        """Functions from the number of a coordinate to its values, or velocities, (k, points) at
        the Chebyshev points of some steps, and the times there."""
        places, slopes = _basis(self.space, points)
        parts, bases = self.coefficients[rows], self.bases[rows]
        begin, lengths = self.begin[rows][:, None], self.lengths[rows][:, None]
        if self.even:
            pace, t = lengths, begin + 0.5 * (1.0 + points_of(points)[0]) * lengths
        else:
            to_values, to_slopes = _lapse_matrices(self.lapses.shape[1], points)
            lapses = self.lapses[rows]
            pace, t = times_matrix(lapses, to_slopes), begin + times_matrix(lapses, to_values)

        def coordinate(i: int) -> Array:
            return bases[:, i, None] + parts[:, i] @ places

        def velocity(i: int) -> Array:
            return parts[:, i] @ slopes / pace

        return coordinate, velocity, t

    def bounds(self, rates: bool, points: int) -> tuple[Array, Array]:
        """The least and the greatest coordinates, or velocities, (d, n) each, from the basis at so
        many Chebyshev points."""
        n, d, _ = self.coefficients.shape
        low, high = np.empty((d, n)), np.empty((d, n))
        spans = _spans(self.space, points)[rates]
        bases = np.zeros((1, d)) if rates else np.ascontiguousarray(self.bases)
        compiled_curve_bounds()(bases, self.coefficients, *spans, low, high)
        if rates:
            low, high = self._over_time(low, high)
        low[:, self.rough], high[:, self.rough] = -np.inf, np.inf
        return low, high

    def _over_time(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Bounds of velocities from those of rates by x."""
        pace = np.stack([self.lengths, self.lengths])
        if not self.even:
            series = chebyshev.chebder(self.lapses, axis=1, scl=2.0)
            spread = np.abs(series[:, 1:]).sum(axis=1)
            pace = series[:, 0] + np.stack([-spread, spread])
        with np.errstate(all="ignore"):
            ends = [edge / rate for edge in (low, high) for rate in pace]
            lowest, greatest = np.minimum.reduce(ends), np.maximum.reduce(ends)
        unknown = (pace[0] * pace[1] <= 0.0) | np.isnan(lowest).any(axis=0)
        lowest[:, unknown], greatest[:, unknown] = -np.inf, np.inf
        return lowest, greatest


def step_polynomials(curves: Any, first: int, begin: Array, end: Array) -> StepPolynomials | None:
    """The polynomials of n steps from ``first`` on, between times (n,), or None."""
    n, lengths = len(begin), end - begin
    rows = slice(first, first + n)
    lapses = 0.5 * np.stack([lengths, lengths], axis=1)
    if isinstance(curves, FrameCurves):
        return _in_frame(curves, rows, begin, lengths)
    clocked = isinstance(curves, ClockCurves)
    if not (clocked or isinstance(curves, Curves)) or not isinstance(curves.chart, IdentityChart):
        return None
    space = curves.method.space if clocked else curves.space
    bounded = isinstance(space, Polynomials | ComponentPolynomials)
    rough = np.zeros(n, dtype=bool)
    if clocked:
        lapses, rough = _clock_lapses(curves, rows)
    return StepPolynomials(
        space,
        curves.bases[rows].reshape(n, -1),
        curves.coefficients[rows],
        begin,
        lapses,
        lengths,
        rough,
        bounded,
    )


def _clock_lapses(curves: ClockCurves, rows: slice) -> tuple[Array, Any]:
    """The coefficients of the times, and the steps in which these do not grow."""
    n = len(curves.rates)
    steps = np.full(n, curves.step)
    steps[-1:] = curves.last
    steps = steps[rows]
    rates = times_matrix(curves.rates[rows], curves.method.table.analysis.T) * steps[:, None]
    l = rates.shape[1] + 1
    x, matrix = points_of(l)
    since = legendre.legval(x, 0.5 * legendre.legint(rates, lbnd=-1.0, axis=1).T)
    values = since.astype(np.float64)
    slopes = legendre.legval(np.append(x, [-1.0, 1.0]), rates.T)
    backwards = ~(slopes * np.sign(steps)[:, None] > 0.0).all(axis=1)
    return times_matrix(values, matrix.T), backwards


def _in_frame(curves: FrameCurves, rows: slice, begin: Array, lengths: Array) -> StepPolynomials:
    n, index = len(begin), np.arange(rows.start, rows.stop)
    rough = np.isnan(curves.coefficients[index, -1, -1])
    left, shape = np.flatnonzero(~rough), curves.path.problem.q0.shape
    D, d = shape[-1], math.prod(shape)
    series, lapses = np.zeros((n, d, 1)), 0.5 * np.stack([lengths, lengths], axis=1)
    for among_nodes, points in INTERPOLATIONS:
        if not left.size:
            break
        parts = [
            _interpolated(curves, index[left[k : k + STEPS_TOGETHER]], points, among_nodes)
            for k in range(0, len(left), STEPS_TOGETHER)
        ]
        places, times = (np.concatenate(x) for x in zip(*parts, strict=True))
        series, lapses = _padded(series, places.shape[2]), _padded(lapses, times.shape[1])
        series[left], lapses[left] = places, _padded(times, lapses.shape[1])
        smooth = _smooth(places, np.abs(places).reshape(len(left), -1, D * places.shape[2]))
        if among_nodes:
            smooth &= _smooth(times[:, None], np.abs(times)[:, None])
        left = left[~smooth]
    rough[left] = True
    bases = np.matmul(series, (-1.0) ** np.arange(series.shape[2])[:, None])[..., 0]
    return StepPolynomials(
        Chebyshev(series.shape[2]),
        bases,
        series[:, :, 1:].copy(),
        begin,
        lapses,
        lengths,
        rough,
        True,
    )


def _padded(series: Array, points: int) -> Array:
    """Padded with zeros to at least ``points`` coefficients."""
    missing = max(points - series.shape[-1], 0)
    return np.pad(series, [(0, 0)] * (series.ndim - 1) + [(0, missing)])


def _smooth(series: Array, sizes: Array) -> Any:
    """Whether the last coefficients of all series of a step are small (k,), relative to the largest
    ones of ``sizes`` (k, bodies, ...)."""
    largest = sizes.max(axis=2)
    last = np.abs(series[:, :, -2:]).reshape(*largest.shape, -1).max(axis=2)
    return (last <= SMOOTH * largest).all(axis=1)


def _interpolated(
    curves: FrameCurves, index: Any, points: int, among_nodes: bool
) -> tuple[Array, Array]:
    """Chebyshev coefficients of the places (k, d, points) and of the times (k, l), with x the place
    among a step's nodes, or its fraction in time."""
    (x, matrix), number = points_of(points), curves.first + index[:, None]
    share, step, shape = 0.5 * (1.0 + x), curves.step, (len(index), points)
    if among_nodes:
        c = np.broadcast_to(share, shape)
        since = np.broadcast_to(curves.path.times(number, share)[0], shape)
        lapses = times_matrix(since + 0.5 * step, matrix.T)
    else:
        since = np.broadcast_to((share - 0.5) * step, shape)
        c = np.broadcast_to(curves.path.node(number, share)[0], shape)
        lapses = np.full((len(index), 2), 0.5 * step)
    q = curves.path.positions(curves, index, c, since)
    return np.matmul(q, matrix.T), lapses


@lru_cache(maxsize=16)
def _basis(space: Any, n: int) -> tuple[Array, Array]:
    """The basis functions of a step's curve, less their values at its start, and their
    derivatives, (m, n) at the Chebyshev points."""
    share = np.append(0.5 * (1.0 + points_of(n)[0]), 0.0)
    basis, slope = space.basis(share)[:, 1:], space.derivative(share)[:-1, 1:]
    return (basis[:-1] - basis[-1]).T.copy(), slope.T.copy()


@lru_cache(maxsize=16)
def _spans(space: Any, n: int) -> tuple[Array, Array]:
    """Centre and radius (2, m) of an interval that contains each basis function of `_basis`, and
    each derivative: its first Chebyshev coefficient and the sum of the sizes of the others."""
    both = (values @ points_of(n)[1].T for values in _basis(space, n))
    places, rates = (np.stack([x[:, 0], np.abs(x[:, 1:]).sum(axis=1)]) for x in both)
    return places, rates


@lru_cache(maxsize=16)
def _lapse_matrices(l: int, n: int) -> tuple[Array, Array]:
    """(l, n) from Chebyshev coefficients to values at n Chebyshev points, and to slopes by x."""
    x, slopes = points_of(n)[0], chebyshev.chebder(np.eye(l), axis=0, scl=2.0)
    values, paces = chebyshev.chebvander(x, l - 1), chebyshev.chebvander(x, l - 2) @ slopes
    return values.T.astype(np.float64, order="C"), paces.T.astype(np.float64, order="C")
