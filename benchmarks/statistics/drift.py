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

FEWEST_TIMES = 40  # fewest times, and fewest segments where there are as many
SEGMENT = 10  # fewest times in a segment where there are as many
WIDTH = 4  # segments over which means are taken
BLOCKS = 10  # consecutive blocks of the bootstrap in a run
EVEN = 1e-6  # relative tolerance for equal distances of times


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

    NaN unless all are finite and k >= 40. A beat that takes longer than the run looks like a drift.
    """
    from scipy.ndimage import maximum_filter1d  # half a second

    t, errors = np.asarray(t, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    if t.size < FEWEST_TIMES or not np.all(np.isfinite(errors)):
        return Drift(math.nan, math.nan, math.nan, math.nan, math.nan)
    steps = np.diff(t)
    if not np.ptp(steps) <= EVEN * abs(float(np.mean(steps))):
        raise ValueError("expected evenly spaced times; received others. Sample the run evenly.")
    largest = float(np.max(np.abs(errors)))
    if largest == 0.0:
        return Drift(0.0, 0.0, 0.0, 0.0, 0.0)
    y = errors / largest
    segment = min(max(math.ceil(period(y)), SEGMENT), t.size // FEWEST_TIMES)
    maxima = maximum_filter1d(np.abs(y), segment)
    trend, growth = (
        [t.size / (segment * means.size) * x for x in change(means)]
        for means in (smooth(y, segment), smooth(maxima / np.mean(maxima), segment))
    )
    return Drift(*trend, *growth, largest)


def smooth(y: Array, segment: int) -> Array:
    """Means of y, one for each segment, with weights that reach over WIDTH of them."""
    weights = np.hanning(WIDTH * segment + 2)[1:-1]
    means = np.convolve(y, weights / np.sum(weights), "valid")
    return means[(means.size - 1) % segment :: segment]


def period(y: Array) -> float:
    """The period of the strongest line in the spectrum of y less its trend, in samples; its length
    where there is none."""
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
    taper = np.hanning(max(3, y.size // BLOCKS) + 2)[1:-1]
    taper /= np.sqrt(taper @ taper)
    variance = np.mean((sliding_window_view(residuals, taper.size) @ taper) ** 2)  # of long sums
    return total_change, float(np.sqrt(variance * (slope @ slope)))


# Growth of an error with time over an ensemble of runs: random walk or drift.
#
# Random rounding changes the energy as t^1/2 (Brouwer), systematic rounding as t.

RESAMPLES = 400
CHANCE = 1e-4  # significance level of a drift


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
        return bool(2.0 * stdtr(self.runs - 1, -abs(self.sigmas)) < CHANCE)


def growth(t: Array, errors: Array, decades: float = 2.0, floor: float = 0.0) -> Growth:
    """The growth of errors (runs, times) at increasing positive times t, over the last `decades`.

    floor  RMS up to which the rounding of the state hides its error: times up to the last one that
           low are left out of the fit of the exponent
    All fields are NaN unless three times remain, every error is finite, and there are two runs.
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
    low = np.flatnonzero(size <= floor)
    window[: low[-1] + 1 if low.size else 0] = False
    if np.count_nonzero(window) < 3 or not np.all(size[window] > 0.0):
        return Growth(nan, nan, nan, nan, nan, float(size[-1]), drift, spread, len(errors))
    x = np.log(t[window])
    exponent, constant = _line(x, np.log(size[window]))
    draws = np.random.default_rng(0).integers(len(errors), size=(RESAMPLES, len(errors)))
    drawn = np.stack([rms(errors[rows][:, window]) for rows in draws])
    centred = x - x.mean()
    exponents = np.log(np.maximum(drawn, np.finfo(float).tiny)) @ centred / (centred @ centred)
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
    """Slopes of each run's errors against time, (runs,), independent of a constant offset."""
    centred = t - t.mean()
    return errors @ centred / (centred @ centred)
