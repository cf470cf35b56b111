"""Trend and growth of an error over a long run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from galvi.arrays import Array

LEAST = 8  # fewest times


@dataclass(frozen=True)
class Drift:
    """Trend and growth of |error|.

    trend        slope of |error| over the run, times its length, over its largest value
    uncertainty  standard error of the trend
    growth       largest |error| in the last quarter of the run, over that in the first quarter
    largest      largest |error|
    """

    trend: float
    uncertainty: float
    growth: float
    largest: float


def drift(t: Array, errors: Array) -> Drift:
    """The drift of errors at increasing times t, both (k,); NaN unless finite and k >= 8."""
    t, size = np.asarray(t, dtype=np.float64), np.abs(np.asarray(errors, dtype=np.float64))
    if t.size < LEAST or not np.all(np.isfinite(size)):
        return Drift(math.nan, math.nan, math.nan, math.nan)
    largest = float(size.max())
    if largest == 0.0:
        return Drift(0.0, 0.0, 1.0, 0.0)
    x = (t - t.mean()) / (t[-1] - t[0])
    y = size / largest
    trend = float(x @ y / (x @ x))
    rest = y - y.mean() - trend * x
    spread = float(np.sqrt(rest @ rest / (t.size - 2) / (x @ x)))
    quarter = t.size // 4
    first, last = float(size[1 : quarter + 1].max()), float(size[-quarter:].max())
    return Drift(trend, spread, last / first if first > 0.0 else np.inf, largest)
