"""Roots of Chebyshev series, isolated by bounds of halves of halves."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebvander

from galvi.arrays import Array

INTERVAL_HALVINGS = 40  # of a step, to isolate roots
TRAILING_COEFFICIENT = 1e-16  # of the largest coefficient, up to which the last ones are left out
# Of the largest coefficient, up to which a part of a series is 0; and the least of it.
ZERO_SERIES, LEAST_COEFFICIENT = 4e-16, 1e-300
ROOT_ITERATIONS, ROOT_CHANGE = (
    60,
    1e-10,
)  # of Newton's method for a root of an interpolant, and its end


def roots(series: Array, starts: Array, ends: Array) -> tuple[Any, Array, Any, Array]:
    """Row, place in (-1, 1], direction and slope (k,) of the roots of n series with a change of
    sign.

    A half has none where its first coefficient exceeds the sum of the others, and at most one where
    that holds of its derivative.

    Parameters
    ----------
    starts, ends : array, shape (n,)
        values where the series begin and end, or their signs
    """
    scale = np.maximum(np.abs(series).max(axis=1), LEAST_COEFFICIENT)
    series, starts, ends = series / scale[:, None], np.sign(starts), np.sign(ends)
    some = np.flatnonzero((np.abs(series) > TRAILING_COEFFICIENT).any(axis=0))
    series = series[:, : max(some[-1] + 1 if some.size else 0, 2)]
    halves, rows = _halves(series.shape[1]), np.arange(len(series))
    left, half = np.full(len(series), -1.0), 1.0
    isolated: list[tuple[Any, ...]] = []
    for k in range(INTERVAL_HALVINGS + 1):
        if not rows.size:
            break
        middle, spread = series[:, 0], np.abs(series[:, 1:]).sum(axis=1)
        maybe = (np.abs(middle) <= spread) | (starts * middle <= 0.0) | (ends * middle <= 0.0)
        slopes = times_matrix(series, _derivative(series.shape[1]))
        single = np.abs(slopes[:, 0]) > np.abs(slopes[:, 1:]).sum(axis=1)
        single |= (np.abs(middle) + spread <= ZERO_SERIES) | (k == INTERVAL_HALVINGS)
        crosses = (starts * ends < 0.0) | ((ends == 0.0) & (starts != 0.0))
        with_one_root = np.flatnonzero(maybe & single & crosses)
        halves_of = np.full(len(with_one_root), half)
        isolated.append(
            (
                rows[with_one_root],
                left[with_one_root],
                halves_of,
                starts[with_one_root],
                ends[with_one_root],
                series[with_one_root],
                slopes[with_one_root],
            )
        )
        to_halve = np.flatnonzero(maybe & ~single)
        half *= 0.5
        rows, left = np.repeat(rows[to_halve], 2), np.repeat(left[to_halve], 2)
        left[1::2] += 2.0 * half
        series, starts, ends = (
            np.repeat(array[to_halve], 2, axis=0) for array in (series, starts, ends)
        )
        series[::2] = times_matrix(series[::2], halves[0])
        series[1::2] = times_matrix(series[1::2], halves[1])
        between = series[::2].sum(axis=1)
        between = np.where(between == 0.0, np.copysign(1.0, starts[::2]), np.sign(between))
        ends[::2], starts[1::2] = between, between
    if not isolated:
        return rows, left, rows, left
    rows, left, wide, starts, ends, series, slopes = map(
        np.concatenate, zip(*isolated, strict=True)
    )
    x, slope = _places(series, slopes, starts)
    x[ends == 0.0] = 1.0
    rises = np.sign(ends - starts).astype(np.int64)
    return rows, left + wide * (1.0 + x), rises, slope * scale[rows] / wide


def times_matrix(rows: Array, matrix: Array) -> Array:
    """rows @ matrix, one row after another: threads, which wait busily, would take longer."""
    return np.matmul(rows[:, None], matrix)[:, 0]


@lru_cache(maxsize=64)
def _derivative(n: int) -> Array:
    """The matrix (n, n - 1) from the coefficients of a series to those of its derivative."""
    return chebder(np.eye(n), axis=1).astype(np.float64)


@lru_cache(maxsize=64)
def _halves(n: int) -> tuple[Array, Array]:
    """The matrices (n, n) by which a series becomes those of its halves."""
    x, back = points_of(n)
    left, right = ((back @ chebvander(0.5 * (x + end), n - 1)).T for end in (-1.0, 1.0))
    return left.copy(), right.copy()


@lru_cache(maxsize=64)
def points_of(n: int) -> tuple[Array, Array]:
    """Chebyshev points in (-1, 1), and the matrix from values there to coefficients."""
    x: Array = chebpts1(n)
    return x, np.linalg.inv(chebvander(x, n - 1)).astype(np.float64)


def _places(series: Array, slopes: Any, starts: Array) -> tuple[Array, Array]:
    """The places at which n series change their sign from that of ``starts``, and the slopes there,
    by bracketed Newton iterations."""
    places, slope = np.zeros(len(series)), np.zeros(len(series))
    rows, low, high = np.arange(len(places)), places - 1.0, places + 1.0
    degrees = np.arange(series.shape[1])
    for _ in range(ROOT_ITERATIONS):
        if not rows.size:
            break
        x = places[rows]
        values = np.cos(np.arccos(x)[:, None] * degrees)
        f, slope[rows] = (
            np.sum(c[rows] * values[:, : c.shape[1]], axis=1) for c in (series, slopes)
        )
        before = f * starts[rows] > 0.0
        low, high = np.where(before, x, low), np.where(before, high, x)
        with np.errstate(all="ignore"):
            new = x - f / slope[rows]
        places[rows] = np.where((new > low) & (new < high), new, 0.5 * (low + high))
        moving = np.abs(places[rows] - x) > ROOT_CHANGE
        rows, low, high = rows[moving], low[moving], high[moving]
    return places, slope
