"""The coordinates and the time of many steps, as polynomials of one variable on each of them.

The variable x runs from 0 to 1. It is the fraction of the step in time; in a clock, the fraction in
tau; in a frame, the fraction in time or, where the motion is not smooth in that, the fraction among
the nodes. In a frame positions are no polynomials of x: they are interpolated at Chebyshev points,
at more of them until the last coefficients are small.
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

# (whether x is the fraction among nodes, number of points), tried in turn in a frame; eccentric
# orbits are smooth functions of the fraction among nodes.
INTERPOLATIONS = ((False, 11), (True, 24), (True, 48))
SMOOTH = 1e-10  # largest of the last two coefficients of a resolved series, relative to its largest
STEPS_TOGETHER = 1024  # steps in a frame that are interpolated at once

OfCoordinate = Callable[[int], Array]  # from the index of a coordinate


@dataclass(frozen=True)
class Chebyshev:
    """T_0 to T_(n-1) on [0, 1], with the ``basis`` and ``derivative`` of a `galvi.Space`."""

    dimension: int

    def basis(self, x: Array) -> Array:
        """(k, n) at x (k,)."""
        return chebyshev.chebvander(2.0 * x - 1.0, self.dimension - 1).astype(np.float64)

    def derivative(self, x: Array) -> Array:
        """Derivatives with respect to x, (k, n)."""
        slopes = chebyshev.chebder(np.eye(self.dimension), axis=0, scl=2.0)
        return chebyshev.chebvander(2.0 * x - 1.0, self.dimension - 2) @ slopes


class StepPolynomials(NamedTuple):
    """The coordinates and times of n steps, as functions of x in [0, 1].

    Attributes
    ----------
    space
        psi_i are its basis functions after the constant, minus their values at 0
    bases : array, shape (n, d)
        coordinates at x = 0
    coefficients : array, shape (n, d, m)
        of psi_i in each coordinate
    begin : array, shape (n,)
        the times at x = 0
    times_since_begin : array, shape (n, l)
        Chebyshev coefficients of the times since the start of the step
    lengths : array, shape (n,)
        of the steps, in time
    unusable : array, shape (n,)
        whether a step has no such polynomials: its time does not run in one direction, or, in a
        frame, it was done in the inertial frame or is not resolved by the interpolation
    is_polynomial
        whether ``space`` is one of polynomials, so that `bounds` are bounds
    """

    space: Any
    bases: Array
    coefficients: Array
    begin: Array
    times_since_begin: Array
    lengths: Array
    unusable: Any
    is_polynomial: bool

    @property
    def time_is_linear(self) -> bool:
        """Whether the times of all steps are linear in x."""
        return self.times_since_begin.shape[1] == 2

    def times(self, rows: Any, x: Array) -> tuple[Array, Array]:
        """The times at x (k,) of the steps ``rows`` (k,), and dt/dx."""
        series, y = self.times_since_begin[rows], 2.0 * x - 1.0
        values = chebyshev.chebvander(y, series.shape[1] - 1)
        slopes = chebyshev.chebvander(y, series.shape[1] - 2)
        dt_dx = chebyshev.chebder(series, axis=1, scl=2.0)
        t = self.begin[rows] + np.sum(values * series, axis=1)
        return t, np.sum(slopes * dt_dx, axis=1)

    def at_points(self, rows: Any, points: int) -> tuple[OfCoordinate, OfCoordinate, Array]:
        """At ``points`` Chebyshev points of the steps ``rows``, k of them: two functions of the
        index of a coordinate, of its values and of its velocities (k, points), and the times."""
        basis_values, basis_slopes = _basis(self.space, points)
        parts, bases = self.coefficients[rows], self.bases[rows]
        begin, lengths = self.begin[rows][:, None], self.lengths[rows][:, None]
        if self.time_is_linear:
            dt_dx, t = lengths, begin + 0.5 * (1.0 + points_of(points)[0]) * lengths
        else:
            to_values, to_slopes = _time_matrices(self.times_since_begin.shape[1], points)
            series = self.times_since_begin[rows]
            dt_dx, t = times_matrix(series, to_slopes), begin + times_matrix(series, to_values)

        def coordinate(i: int) -> Array:
            return bases[:, i, None] + parts[:, i] @ basis_values

        def velocity(i: int) -> Array:
            return parts[:, i] @ basis_slopes / dt_dx

        return coordinate, velocity, t

    def bounds(self, of_velocities: bool, points: int) -> tuple[Array, Array]:
        """Lower and upper bounds of coordinates or velocities, (d, n) each.

        Infinite for unusable steps. They hold, up to rounding, for basis functions that are
        polynomials of a degree below ``points``.
        """
        n, d, _ = self.coefficients.shape
        low, high = np.empty((d, n)), np.empty((d, n))
        value_spans, slope_spans = _spans(self.space, points)
        spans = slope_spans if of_velocities else value_spans
        bases = np.zeros((1, d)) if of_velocities else np.ascontiguousarray(self.bases)
        compiled_curve_bounds()(bases, self.coefficients, *spans, low, high)
        if of_velocities:
            low, high = self._over_time(low, high)
        low[:, self.unusable], high[:, self.unusable] = -np.inf, np.inf
        return low, high

    def _over_time(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Bounds of velocities from those of derivatives with respect to x."""
        dt_dx = np.stack([self.lengths, self.lengths])
        if not self.time_is_linear:
            series = chebyshev.chebder(self.times_since_begin, axis=1, scl=2.0)
            spread = np.abs(series[:, 1:]).sum(axis=1)
            dt_dx = series[:, 0] + np.stack([-spread, spread])
        with np.errstate(all="ignore"):
            quotients = [edge / rate for edge in (low, high) for rate in dt_dx]
            lowest, greatest = np.minimum.reduce(quotients), np.maximum.reduce(quotients)
        unknown = (dt_dx[0] * dt_dx[1] <= 0.0) | np.isnan(lowest).any(axis=0)
        lowest[:, unknown], greatest[:, unknown] = -np.inf, np.inf
        return lowest, greatest


def step_polynomials(curves: Any, first: int, begin: Array, end: Array) -> StepPolynomials | None:
    """The polynomials of n steps from ``first`` on, which begin and end at these times (n,).

    None on Lie groups, and for curves of another class.
    """
    n, lengths = len(begin), end - begin
    rows = slice(first, first + n)
    times_since_begin = 0.5 * np.stack([lengths, lengths], axis=1)
    if isinstance(curves, FrameCurves):
        return _in_frame(curves, rows, begin, lengths)
    clocked = isinstance(curves, ClockCurves)
    if not (clocked or isinstance(curves, Curves)) or not isinstance(curves.chart, IdentityChart):
        return None
    space = curves.method.space if clocked else curves.space
    is_polynomial = isinstance(space, Polynomials | ComponentPolynomials)
    unusable = np.zeros(n, dtype=bool)
    if clocked:
        times_since_begin, unusable = _clock_times(curves, rows)
    return StepPolynomials(
        space,
        curves.bases[rows].reshape(n, -1),
        curves.coefficients[rows],
        begin,
        times_since_begin,
        lengths,
        unusable,
        is_polynomial,
    )


def _clock_times(curves: ClockCurves, rows: slice) -> tuple[Array, Any]:
    """The coefficients of the times since the start of each step, and a mask (n,) of the steps in
    which time does not run in the step's direction at one of the points tested."""
    n = len(curves.rates)
    steps = np.full(n, curves.step)
    steps[-1:] = curves.last
    steps = steps[rows]
    dt_dx = times_matrix(curves.rates[rows], curves.method.table.analysis.T) * steps[:, None]
    l = dt_dx.shape[1] + 1
    y, matrix = points_of(l)
    since = legendre.legval(y, 0.5 * legendre.legint(dt_dx, lbnd=-1.0, axis=1).T)
    values = since.astype(np.float64)
    slopes = legendre.legval(np.append(y, [-1.0, 1.0]), dt_dx.T)
    backwards = ~(slopes * np.sign(steps)[:, None] > 0.0).all(axis=1)
    return times_matrix(values, matrix.T), backwards


def _in_frame(curves: FrameCurves, rows: slice, begin: Array, lengths: Array) -> StepPolynomials:
    """The polynomials of steps in a moving frame, interpolated as in INTERPOLATIONS."""
    n, index = len(begin), np.arange(rows.start, rows.stop)
    unusable = np.isnan(curves.coefficients[index, -1, -1])
    left, shape = np.flatnonzero(~unusable), curves.path.problem.q0.shape
    D, d = shape[-1], math.prod(shape)
    series, times_since_begin = np.zeros((n, d, 1)), 0.5 * np.stack([lengths, lengths], axis=1)
    for among_nodes, points in INTERPOLATIONS:
        if not left.size:
            break
        parts = [
            _interpolated(curves, index[left[k : k + STEPS_TOGETHER]], points, among_nodes)
            for k in range(0, len(left), STEPS_TOGETHER)
        ]
        position_series, time_series = (np.concatenate(x) for x in zip(*parts, strict=True))
        series, times_since_begin = (
            _padded(series, position_series.shape[2]),
            _padded(times_since_begin, time_series.shape[1]),
        )
        series[left], times_since_begin[left] = (
            position_series,
            _padded(time_series, times_since_begin.shape[1]),
        )
        resolved = _is_resolved(
            position_series,
            np.abs(position_series).reshape(len(left), -1, D * position_series.shape[2]),
        )
        if among_nodes:
            resolved &= _is_resolved(time_series[:, None], np.abs(time_series)[:, None])
        left = left[~resolved]
    unusable[left] = True
    bases = np.matmul(series, (-1.0) ** np.arange(series.shape[2])[:, None])[..., 0]
    return StepPolynomials(
        Chebyshev(series.shape[2]),
        bases,
        series[:, :, 1:].copy(),
        begin,
        times_since_begin,
        lengths,
        unusable,
        True,
    )


def _padded(series: Array, points: int) -> Array:
    """A series padded with zeros to at least ``points`` coefficients."""
    missing = max(points - series.shape[-1], 0)
    return np.pad(series, [(0, 0)] * (series.ndim - 1) + [(0, missing)])


def _is_resolved(series: Array, sizes: Array) -> Any:
    """Whether the last coefficients of all series of a step are small (k,), relative to the largest
    ones of ``sizes`` (k, bodies, ...)."""
    largest = sizes.max(axis=2)
    last = np.abs(series[:, :, -2:]).reshape(*largest.shape, -1).max(axis=2)
    return (last <= SMOOTH * largest).all(axis=1)


def _interpolated(
    curves: FrameCurves, index: Any, points: int, among_nodes: bool
) -> tuple[Array, Array]:
    """Chebyshev coefficients of positions (k, d, points) and of times since the start of the step
    (k, l), where x is the fraction among its nodes or in time."""
    (y, matrix), number = points_of(points), curves.first + index[:, None]
    x, step, shape = 0.5 * (1.0 + y), curves.step, (len(index), points)
    if among_nodes:
        c = np.broadcast_to(x, shape)
        since = np.broadcast_to(curves.path.times(number, x)[0], shape)
        times_since_begin = times_matrix(since + 0.5 * step, matrix.T)
    else:
        since = np.broadcast_to((x - 0.5) * step, shape)
        c = np.broadcast_to(curves.path.node(number, x)[0], shape)
        times_since_begin = np.full((len(index), 2), 0.5 * step)
    q = curves.path.positions(curves, index, c, since)
    return np.matmul(q, matrix.T), times_since_begin


@lru_cache(maxsize=16)
def _basis(space: Any, n: int) -> tuple[Array, Array]:
    """The basis functions of a step's curve, less their values at its start, and their
    derivatives, (m, n) at the Chebyshev points."""
    x = np.append(0.5 * (1.0 + points_of(n)[0]), 0.0)
    basis, slope = space.basis(x)[:, 1:], space.derivative(x)[:-1, 1:]
    return (basis[:-1] - basis[-1]).T.copy(), slope.T.copy()


@lru_cache(maxsize=16)
def _spans(space: Any, n: int) -> tuple[Array, Array]:
    """Centre and radius (2, m) of an interval that contains each basis function of `_basis`, and
    each derivative: its first Chebyshev coefficient and the sum of the sizes of the others."""
    both = (values @ points_of(n)[1].T for values in _basis(space, n))
    values, slopes = (np.stack([x[:, 0], np.abs(x[:, 1:]).sum(axis=1)]) for x in both)
    return values, slopes


@lru_cache(maxsize=16)
def _time_matrices(l: int, n: int) -> tuple[Array, Array]:
    """(l, n) from Chebyshev coefficients to values at n Chebyshev points, and to derivatives with
    respect to x."""
    y, slopes = points_of(n)[0], chebyshev.chebder(np.eye(l), axis=0, scl=2.0)
    values, dt_dx = chebyshev.chebvander(y, l - 1), chebyshev.chebvander(y, l - 2) @ slopes
    return values.T.astype(np.float64, order="C"), dt_dx.T.astype(np.float64, order="C")
