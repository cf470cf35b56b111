"""Roots of Chebyshev series, isolated by bounds on repeatedly halved intervals."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebvander

from galvi.arrays import Array

INTERVAL_HALVINGS = 40  # largest number of halvings of a step that isolate a root
TRAILING_COEFFICIENT = 1e-16  # share of the largest coefficient, up to which the last are left out
ZERO_SERIES = 4e-16  # share of the largest coefficient, up to which a series is 0 on an interval
LEAST_COEFFICIENT = 1e-300  # least scale of a series, so that one of zeros can be divided
ROOT_ITERATIONS = 60  # largest number of bracketed Newton iterations for a root
ROOT_CHANGE = 1e-10  # change in (-1, 1) up to which these iterations have converged


def roots(series: Array, starts: Array, ends: Array) -> tuple[Any, Array, Any, Array]:
    """The roots at which n Chebyshev series (n, m) on [-1, 1] change their sign.

    An interval has no root where the first coefficient of the series there exceeds the sum of the
    sizes of the others, and at most one where that holds for the derivative.

    Parameters
    ----------
    starts, ends : array, shape (n,)
        values of the series at -1 and 1, or their signs

    Returns
    -------
    row, x, rises, slope : array, shape (k,)
        index of the series, root in (-1, 1], 1 where the series rises and -1 where it falls, and
        its derivative by x
    """
    scale = np.maximum(np.abs(series).max(axis=1), LEAST_COEFFICIENT)
    series, starts, ends = series / scale[:, None], np.sign(starts), np.sign(ends)
    nonzero_columns = np.flatnonzero((np.abs(series) > TRAILING_COEFFICIENT).any(axis=0))
    series = series[:, : max(nonzero_columns[-1] + 1 if nonzero_columns.size else 0, 2)]
    halving_matrices, rows = _halves(series.shape[1]), np.arange(len(series))
    left_ends, half_width = np.full(len(series), -1.0), 1.0
    isolated: list[tuple[Any, ...]] = []
    for k in range(INTERVAL_HALVINGS + 1):
        if not rows.size:
            break
        middle, spread = series[:, 0], np.abs(series[:, 1:]).sum(axis=1)
        may_have_root = (
            (np.abs(middle) <= spread) | (starts * middle <= 0.0) | (ends * middle <= 0.0)
        )
        slopes = times_matrix(series, _derivative(series.shape[1]))
        is_monotone = np.abs(slopes[:, 0]) > np.abs(slopes[:, 1:]).sum(axis=1)
        is_monotone |= (np.abs(middle) + spread <= ZERO_SERIES) | (k == INTERVAL_HALVINGS)
        crosses = (starts * ends < 0.0) | ((ends == 0.0) & (starts != 0.0))
        with_one_root = np.flatnonzero(may_have_root & is_monotone & crosses)
        halves_of = np.full(len(with_one_root), half_width)
        isolated.append(
            (
                rows[with_one_root],
                left_ends[with_one_root],
                halves_of,
                starts[with_one_root],
                ends[with_one_root],
                series[with_one_root],
                slopes[with_one_root],
            )
        )
        to_halve = np.flatnonzero(may_have_root & ~is_monotone)
        half_width *= 0.5
        rows, left_ends = np.repeat(rows[to_halve], 2), np.repeat(left_ends[to_halve], 2)
        left_ends[1::2] += 2.0 * half_width
        series, starts, ends = (
            np.repeat(array[to_halve], 2, axis=0) for array in (series, starts, ends)
        )
        series[::2] = times_matrix(series[::2], halving_matrices[0])
        series[1::2] = times_matrix(series[1::2], halving_matrices[1])
        middle_signs = series[::2].sum(axis=1)
        middle_signs = np.where(
            middle_signs == 0.0, np.copysign(1.0, starts[::2]), np.sign(middle_signs)
        )
        ends[::2], starts[1::2] = middle_signs, middle_signs
    if not isolated:
        return rows, left_ends, rows, left_ends
    rows, left_ends, half_widths, starts, ends, series, slopes = map(
        np.concatenate, zip(*isolated, strict=True)
    )
    x, slope = _refine_roots(series, slopes, starts)
    x[ends == 0.0] = 1.0
    rises = np.sign(ends - starts).astype(np.int64)
    return rows, left_ends + half_widths * (1.0 + x), rises, slope * scale[rows] / half_widths


def times_matrix(rows: Array, matrix: Array) -> Array:
    """rows @ matrix, one row after another, since the threads of a larger product take longer."""
    return np.matmul(rows[:, None], matrix)[:, 0]


@lru_cache(maxsize=64)
def _derivative(n: int) -> Array:
    """The matrix (n, n - 1) from the coefficients of a series to those of its derivative."""
    return chebder(np.eye(n), axis=1).astype(np.float64)


@lru_cache(maxsize=64)
def _halves(n: int) -> tuple[Array, Array]:
    """The matrices (n, n) from the coefficients of a series to those on its left and right half."""
    x, to_coefficients = points_of(n)
    left, right = ((to_coefficients @ chebvander(0.5 * (x + end), n - 1)).T for end in (-1.0, 1.0))
    return left.copy(), right.copy()


@lru_cache(maxsize=64)
def points_of(n: int) -> tuple[Array, Array]:
    """Chebyshev points in (-1, 1), and the matrix from values there to coefficients."""
    x: Array = chebpts1(n)
    return x, np.linalg.inv(chebvander(x, n - 1)).astype(np.float64)


def _refine_roots(series: Array, slopes: Any, starts: Array) -> tuple[Array, Array]:
    """The roots (n,) in [-1, 1] at which n series change their sign from that of ``starts``, and
    the slopes there, by bracketed Newton iterations."""
    x_of_roots, slope = np.zeros(len(series)), np.zeros(len(series))
    rows, low, high = np.arange(len(x_of_roots)), x_of_roots - 1.0, x_of_roots + 1.0
    degrees = np.arange(series.shape[1])
    for _ in range(ROOT_ITERATIONS):
        if not rows.size:
            break
        x = x_of_roots[rows]
        values = np.cos(np.arccos(x)[:, None] * degrees)
        f, slope[rows] = (
            np.sum(c[rows] * values[:, : c.shape[1]], axis=1) for c in (series, slopes)
        )
        is_before_root = f * starts[rows] > 0.0
        low, high = np.where(is_before_root, x, low), np.where(is_before_root, high, x)
        with np.errstate(all="ignore"):
            newton_x = x - f / slope[rows]
        x_of_roots[rows] = np.where(
            (newton_x > low) & (newton_x < high), newton_x, 0.5 * (low + high)
        )
        is_moving = np.abs(x_of_roots[rows] - x) > ROOT_CHANGE
        rows, low, high = rows[is_moving], low[is_moving], high[is_moving]
    return x_of_roots, slope
