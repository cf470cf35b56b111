"""Growth of an error with time over an ensemble of runs: random walk or drift.

Random rounding changes the energy as t^1/2 (Brouwer), systematic rounding as t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from galvi.arrays import Array

RESAMPLES = 400
CHANCE = 1e-4  # significance level of a drift


@dataclass(frozen=True)
class Growth:
    """RMS over the ensemble = coefficient * t^exponent, and the mean's drift.

    exponent           by least squares on logarithms
    uncertainty        its bootstrap standard error over the runs
    coefficient        RMS at t = 1, on the line
    first, last        time window of the fit
    final              RMS at the end
    drift              mean over the runs of each one's slope against time
    drift_uncertainty  standard error of that mean
    runs               number of runs
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
    size: Array = np.sqrt(np.mean(errors**2, axis=0))
    return size


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope and intercept of the line through (x, y)."""
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    return slope, float(y.mean() - slope * x.mean())


def _slopes(t: Array, errors: Array) -> Array:
    """Slopes of each run's errors against time, (runs,), independent of a constant offset."""
    centred = t - t.mean()
    slopes: Array = errors @ centred / (centred @ centred)
    return slopes
