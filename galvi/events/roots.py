"""Roots of Chebyshev series, isolated by bounds of their derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from galvi.arrays import Array

HALVINGS = 40
PASSES, CLOSE = 60, 1e-10  # of Newton's method for a root of an interpolant, and its end


def roots(coefficients: Array, starts: Array, ends: Array) -> tuple[Any, Array, Any, Array]:
    """Row, place in (-1, 1], direction and slope (k,) of the roots of n series with a change of
    sign.

    starts, ends  (n,) values where the series begin and end, or their signs
    """
    slopes = chebyshev.chebder(coefficients, axis=1)
    bends = chebyshev.chebder(slopes, axis=1) if slopes.shape[1] > 1 else 0.0 * slopes
    bounds = np.abs(slopes).sum(axis=1), np.abs(bends).sum(axis=1)
    rows, left = np.arange(len(coefficients)), np.full(len(coefficients), -1.0)
    found = [(rows[:0], left[:0], rows[:0], left[:0])]
    half = 1.0

    def sides(rows: Any, low: Array, high: Array) -> tuple[Array, Array]:
        one, other = _at(coefficients[rows], low), _at(coefficients[rows], high)
        return np.where(low == -1.0, starts[rows], one), np.where(high == 1.0, ends[rows], other)

    for k in range(HALVINGS + 1):
        if not rows.size:
            break
        middle = left + half
        f, slope = _at(coefficients[rows], middle), _at(slopes[rows], middle)
        maybe = np.abs(f) <= half * bounds[0][rows]
        maybe |= (left == -1.0) & (f * starts[rows] <= 0.0)  # the end has another sign
        maybe |= (left + 2.0 * half == 1.0) & (f * ends[rows] <= 0.0)
        single = maybe & ((np.abs(slope) > half * bounds[1][rows]) | (k == HALVINGS))
        one, low = rows[single], left[single]  # or too near each other to tell: one, or none
        high = low + 2.0 * half
        begin, end = sides(one, low, high)
        crosses = (begin * end < 0.0) | ((end == 0.0) & (begin != 0.0))
        one, low, high, begin, end = (x[crosses] for x in (one, low, high, begin, end))
        places = _places(coefficients[one], slopes[one], low, high, begin)
        places[end == 0.0] = high[end == 0.0]
        rises = np.sign(end - begin).astype(np.int64)
        found.append((one, places, rises, _at(slopes[one], places)))
        more = maybe & ~single
        rows, left = rows[more], left[more]
        half *= 0.5
        rows, left = np.repeat(rows, 2), (left[:, None] + np.array([0.0, 2.0 * half])).ravel()
    one, places, rises, slope = (np.concatenate(x) for x in zip(*found, strict=True))
    return one, places, rises, slope


def _places(series: Array, slopes: Array, low: Array, high: Array, begin: Array) -> Array:
    """The places in (low, high) at which n series change their sign from that of ``begin``, by
    bracketed Newton iterations."""
    found = 0.5 * (low + high)
    rows = np.arange(len(found))
    for _ in range(PASSES):
        if not rows.size:
            break
        x = found[rows]
        f, slope = _at(series[rows], x), _at(slopes[rows], x)
        before = f * begin[rows] > 0.0
        low, high = np.where(before, x, low), np.where(before, high, x)
        with np.errstate(all="ignore"):
            new = x - f / slope
        found[rows] = np.where((new > low) & (new < high), new, 0.5 * (low + high))
        left = np.abs(found[rows] - x) > CLOSE
        rows, low, high = rows[left], low[left], high[left]
    return found


def _at(coefficients: Any, x: Any) -> Array:
    found: Array = np.einsum("kn,kn->k", chebyshev.chebvander(x, coefficients.shape[1] - 1),
                             coefficients)  # fmt: skip
    return found
