"""From a measurement to a verdict: pure functions, in which NaN never holds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.statistics.convergence_fits import Fit
from galvi.arrays import Array

HOLDS = "holds"
EXCEEDS = "exceeds"
CONTRADICTED = "contradicted"
NOT_RUN = "not run"
INFORMATIVE = "informative"  # of a number that nobody claims anything about

ORDER_RESOLUTION = 0.25  # the papers print orders as multiples of a half
GROWTH = 1.5  # how much larger than in the first quarter an error that does not grow may become
SIGMAS = 3.0


def base(fit: Fit, claimed: float, resolution: float) -> str:
    """Of error = O(claimed^n): a smaller base is better."""
    return _rate(fit, -fit.rate, -claimed, resolution)


def order(fit: Fit, claimed: float, resolution: float = ORDER_RESOLUTION) -> str:
    """Of error = O(h^claimed): a larger order is better."""
    return _rate(fit, fit.rate, claimed, resolution)


def _rate(fit: Fit, rate: float, claimed: float, resolution: float) -> str:
    """Larger is better; the printed number stands for claimed -+ resolution."""
    if not _known(fit):
        return _without_rate(fit)
    if rate > claimed + resolution + 2.0 * fit.uncertainty:
        return EXCEEDS
    if rate < claimed - resolution - 2.0 * fit.uncertainty:
        return CONTRADICTED
    return HOLDS


def converges(fit: Fit) -> str:
    """The order is positive, by two standard errors."""
    if not _known(fit):
        return _without_rate(fit)
    return HOLDS if fit.rate > 2.0 * fit.uncertainty else CONTRADICTED


def at_least_geometric(whole: Fit, early: Fit, late: Fit) -> str:
    """Errors fall by a factor with each n, and that factor does not tend to 1.

    whole, early, late  fits to all errors of a window and to its two halves; an error that fell
                        like a power of n would have a later half that is worse than the earlier
    """
    if not (_known(whole) and _known(early) and _known(late)):
        return _without_rate(whole)
    falls = whole.rate + 2.0 * whole.uncertainty < 1.0
    slack = 2.0 * math.hypot(early.uncertainty, late.uncertainty)
    return HOLDS if falls and late.rate <= early.rate + slack else CONTRADICTED


def every_n_gains(whole: Fit, worst: float, limit: float) -> str:
    """Each further n multiplies the error by at most ``limit``, below 1, until round-off.

    worst  of `benchmarks.statistics.convergence_fits.worst_ratio`; a power of n would bring it
           near 1
    """
    if not (_known(whole) and math.isfinite(worst)):
        return _without_rate(whole)
    return HOLDS if worst <= limit else CONTRADICTED


def _known(fit: Fit) -> bool:
    return math.isfinite(fit.rate) and math.isfinite(fit.uncertainty) and not fit.relapse


def _without_rate(fit: Fit) -> str:
    """Errors that stay large, or become so again, contradict any rate; others are missing."""
    return CONTRADICTED if fit.stays_large or fit.relapse else NOT_RUN


def bound(measured: float, limit: float) -> str:
    """measured <= limit."""
    if not math.isfinite(measured):
        return NOT_RUN
    return HOLDS if measured <= limit else CONTRADICTED


def within(measured: float, low: float, high: float) -> str:
    """low <= measured <= high."""
    if not math.isfinite(measured):
        return NOT_RUN
    return HOLDS if low <= measured <= high else CONTRADICTED


@dataclass(frozen=True)
class Drift:
    """Does |error| grow?

    trend        slope of |error| over the run, times its length, over its largest value
    uncertainty  standard error of that
    growth       largest |error| in the last quarter of the run, over that in the first quarter
    largest      largest |error|
    """

    trend: float
    uncertainty: float
    growth: float
    largest: float


def drift(t: Array, errors: Array) -> Drift:
    """Of an error at times t (increasing), both (k,); NaN unless all are finite and k >= 8."""
    t, size = np.asarray(t, dtype=np.float64), np.abs(np.asarray(errors, dtype=np.float64))
    nan = float("nan")
    if t.size < 8 or not np.all(np.isfinite(size)):
        return Drift(nan, nan, nan, nan)
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


def no_growth(seen: Drift, limit: float, round_off: float = 0.0) -> str:
    """Bounded by ``limit``, and with no trend beyond its 3 sigma and no late growth.

    ``round_off`` is a level, stated by the study, below which growth is that of rounding errors.
    """
    if not math.isfinite(seen.largest):
        return NOT_RUN
    if seen.largest > limit:
        return CONTRADICTED
    flat = seen.trend <= SIGMAS * seen.uncertainty and seen.growth <= GROWTH
    return HOLDS if flat or seen.largest <= round_off else CONTRADICTED
