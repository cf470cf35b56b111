"""Drifts and growths of errors in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.special import stdtr

from galvi.arrays import Array

# Trend and growth of an error over a long run.
#
# An error that neither drifts nor grows is a stationary series: its mean and its maxima over a
# period stay. Both are smoothed over some periods and fitted by a line in time. The weights of both
# vanish smoothly, so that an oscillation hardly leaks into the slope, nor its beat with the
# segments. The standard error comes from the tapered block bootstrap of the residuals (Paparoditis
# and Politis 2001): its variance over all resamples is known in closed form, so that nothing is
# drawn.

LEAST_TIMES = 40  # of a drift, and segments of a run with as many
LEAST_SEGMENT_TIMES = 10  # times in a segment, where the run has enough
SMOOTHING_SEGMENTS = 4  # segments that the weights of a mean cover
BOOTSTRAP_BLOCKS = 10  # consecutive blocks of the bootstrap in a run
EVEN_TOLERANCE = 1e-6  # relative tolerance of the distances of times


@dataclass(frozen=True)
class Drift:
    """Changes of an error over a run, each with its standard error.

    Attributes
    ----------
    trend
        change of the mean, over `largest`; signed
    trend_error
        its standard error
    growth
        change of the maxima of |error| over a period, over their mean
    growth_error
        its standard error
    largest
        largest |error|
    """

    trend: float
    trend_error: float
    growth: float
    growth_error: float
    largest: float


def drift(t: Array, errors: Array) -> Drift:
    """The drift of signed errors at evenly spaced times t, both (k,).

    All fields are NaN unless errors are finite and k >= LEAST_TIMES. A beat that takes longer than
    the run looks like a drift.

    Raises
    ------
    ValueError
        For times that are not evenly spaced.
    """
    from scipy.ndimage import maximum_filter1d  # half a second

    t, errors = np.asarray(t, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    if t.size < LEAST_TIMES or not np.all(np.isfinite(errors)):
        return Drift(math.nan, math.nan, math.nan, math.nan, math.nan)
    steps = np.diff(t)
    if not np.ptp(steps) <= EVEN_TOLERANCE * abs(float(np.mean(steps))):
        raise ValueError("expected evenly spaced times; received others. Sample the run evenly.")
    largest = float(np.max(np.abs(errors)))
    if largest == 0.0:
        return Drift(0.0, 0.0, 0.0, 0.0, 0.0)
    y = errors / largest
    segment = min(max(math.ceil(period(y)), LEAST_SEGMENT_TIMES), t.size // LEAST_TIMES)
    maxima = maximum_filter1d(np.abs(y), segment)
    trend, growth = (
        [t.size / (segment * means.size) * x for x in change(means)]
        for means in (smooth(y, segment), smooth(maxima / np.mean(maxima), segment))
    )
    return Drift(*trend, *growth, largest)


def smooth(y: Array, segment: int) -> Array:
    """Weighted means of y, one for each segment, over SMOOTHING_SEGMENTS segments."""
    weights = np.hanning(SMOOTHING_SEGMENTS * segment + 2)[1:-1]
    means = np.convolve(y, weights / np.sum(weights), "valid")
    return means[(means.size - 1) % segment :: segment]


def period(y: Array) -> float:
    """The period of the strongest spectral line of y less its trend, in samples; y's length where
    there is no line."""
    x = np.linspace(-1.0, 1.0, y.size)
    detrended = y - np.mean(y) - x * (x @ y) / (x @ x)
    lines = np.abs(np.fft.rfft(detrended * np.hanning(y.size)))
    return y.size / max(1, 1 + int(np.argmax(lines[1:])))


def change(y: Array) -> tuple[float, float]:
    """The change of y (k,) over the whole series, by a weighted line, and its standard error."""
    x = (np.arange(y.size) - 0.5 * (y.size - 1)) / y.size
    weights = np.cos(np.pi * x)
    slope = weights * x / (weights @ x**2)
    total_change = float(slope @ y)
    residuals = y - weights @ y / np.sum(weights) - total_change * x
    taper = np.hanning(max(3, y.size // BOOTSTRAP_BLOCKS) + 2)[1:-1]
    taper /= np.sqrt(taper @ taper)
    variance = np.mean((sliding_window_view(residuals, taper.size) @ taper) ** 2)  # of long sums
    return total_change, float(np.sqrt(variance * (slope @ slope)))


# Growth of an error with time over an ensemble of runs: random walk or drift.
#
# Random rounding changes the energy as t^1/2 (Brouwer), systematic rounding as t.

BOOTSTRAP_RESAMPLES = 400
DRIFT_SIGNIFICANCE = 1e-4  # significance level of a drift


@dataclass(frozen=True)
class Growth:
    """RMS over the ensemble = coefficient * t^exponent, and the mean's drift.

    Attributes
    ----------
    exponent
        by least squares on logarithms
    uncertainty
        its bootstrap standard error over the runs
    coefficient
        RMS at t = 1, on the line
    first, last
        time window of the fit
    final
        RMS at the end
    drift
        mean over the runs of each one's slope against time
    drift_uncertainty
        standard error of that mean
    runs
        number of runs
    """

    exponent: float
    uncertainty: float
    coefficient: float
    first: float
    last: float
    final: float
    drift: float
    drift_uncertainty: float
    runs: int

    @property
    def sigmas(self) -> float:
        """The drift in units of its standard error; NaN when the runs have no scatter."""
        if not self.drift_uncertainty > 0.0:
            return float("nan")
        return self.drift / self.drift_uncertainty

    @property
    def drifts(self) -> bool:
        """Whether the mean drift is significant against the scatter of the runs (Student's t)."""
        return bool(2.0 * stdtr(self.runs - 1, -abs(self.sigmas)) < DRIFT_SIGNIFICANCE)


def growth(t: Array, errors: Array, decades: float = 2.0, floor: float = 0.0) -> Growth:
    """The growth of errors (runs, times) at increasing positive times t, over the last `decades`.

    All fields but `runs` are NaN unless there are two runs and every error is finite. The exponent,
    its uncertainty, the coefficient, `first` and `last` are NaN where fewer than three times
    remain, or an RMS among them is 0.

    Parameters
    ----------
    floor
        RMS up to which the rounding of the state hides its error: times up to the last one with
        such an RMS are left out of the fit of the exponent
    """
    t, errors = np.asarray(t, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    nan = float("nan")
    if errors.ndim != 2 or len(errors) < 2 or not np.all(np.isfinite(errors)):
        return Growth(nan, nan, nan, nan, nan, nan, nan, nan, len(errors))
    size = rms(errors)
    window = t >= t[-1] / 10.0**decades * (1.0 - 1e-9)
    slopes = _slopes(t[window], errors[:, window])
    drift = float(slopes.mean())
    spread = float(slopes.std(ddof=1) / np.sqrt(len(slopes)))
    rows_at_floor = np.flatnonzero(size <= floor)
    window[: rows_at_floor[-1] + 1 if rows_at_floor.size else 0] = False
    if np.count_nonzero(window) < 3 or not np.all(size[window] > 0.0):
        return Growth(nan, nan, nan, nan, nan, float(size[-1]), drift, spread, len(errors))
    x = np.log(t[window])
    exponent, constant = _line(x, np.log(size[window]))
    draws = np.random.default_rng(0).integers(len(errors), size=(BOOTSTRAP_RESAMPLES, len(errors)))
    resampled_rms = np.stack([rms(errors[rows][:, window]) for rows in draws])
    centred = x - x.mean()
    exponents = (
        np.log(np.maximum(resampled_rms, np.finfo(float).tiny)) @ centred / (centred @ centred)
    )
    return Growth(
        exponent=exponent,
        uncertainty=float(exponents.std(ddof=1)),
        coefficient=float(np.exp(constant)),
        first=float(t[window][0]),
        last=float(t[-1]),
        final=float(size[-1]),
        drift=drift,
        drift_uncertainty=spread,
        runs=len(errors),
    )


def rms(errors: Array) -> Array:
    """Root mean square over the runs (first axis)."""
    return np.sqrt(np.mean(errors**2, axis=0))


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope and intercept of the line through (x, y)."""
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    return slope, float(y.mean() - slope * x.mean())


def _slopes(t: Array, errors: Array) -> Array:
    """The slope of each run's errors against time, (runs,)."""
    centred = t - t.mean()
    return errors @ centred / (centred @ centred)
