"""Bounds on the decay of errors with n, and on their growth in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.checks.bounds import Bound, Comparison, in_words, standard_errors
from benchmarks.statistics.convergence_fits import Decay
from benchmarks.statistics.drift import Drift

LARGEST_GROWTH = 0.025  # largest change of a constant error over a run; twice as much is detected
SIGMAS = 5.0  # standard errors of that change which must be below it


@dataclass(frozen=True)
class Geometric(Bound):
    """Errors of a Decay shrink geometrically with n, by a factor that does not tend to 1.

    Errors that fall as a power of n would fall more slowly in the later half of the window.
    """

    text = "base below 1 by 2 standard errors, later half of the window not slower"

    def comparisons(self, measured: Decay) -> tuple[Comparison, ...]:
        early, late = measured.early, measured.late
        tolerance = 2.0 * math.hypot(early.uncertainty, late.uncertainty)
        below_one = math.nextafter(1.0 - standard_errors(measured, 0.0), -math.inf)
        return (
            Comparison(measured.fit.rate, high=below_one),
            Comparison(late.rate, high=early.rate, tolerance=tolerance),
        )


@dataclass(frozen=True)
class FactorPerN(Bound):
    """Each increase of n multiplies the error of a Decay by at most `limit` < 1, until round-off.

    For errors that fall as a power of n the largest of these factors would be near 1.
    """

    limit: float

    @property
    def text(self) -> str:
        return f"each n multiplies the error by at most {in_words(self.limit)}, until round-off"

    def comparisons(self, measured: Decay) -> tuple[Comparison, ...]:
        return (Comparison(measured.worst, high=self.limit),)


@dataclass(frozen=True)
class NoGrowth(Bound):
    """The largest error of a Drift is at most `limit`, and neither mean nor maxima change.

    A change of twice LARGEST_GROWTH over the run is detected, as a trend of the mean in either
    direction or as a growth of the maxima over a period. Where the standard errors are too large
    for that, a change beyond SIGMAS of them is still CONTRADICTED; otherwise the run is too short.

    Attributes
    ----------
    round_off
        absolute change that is attributed to rounding
    conclusive
        whether a run that is too short is NOT_RUN; otherwise its comparisons count
    """

    limit: float
    round_off: float = 0.0
    conclusive: bool = True

    @property
    def text(self) -> str:
        rounded = f" or {in_words(self.round_off)}" if self.round_off else ""
        return (
            f"at most {in_words(self.limit)}; over the run the mean, and the maxima of its "
            f"periods, change by at most {100.0 * LARGEST_GROWTH:g} %{rounded}, or by {SIGMAS:g} "
            "standard errors where that is more"
        )

    def comparisons(self, measured: Drift) -> tuple[Comparison, ...]:
        largest = Comparison(measured.largest, high=self.limit)
        if measured.largest <= self.round_off:
            return (largest,)
        tolerance = max(LARGEST_GROWTH, self.round_off / measured.largest)
        sizes = (abs(measured.trend), measured.growth)
        errors = (SIGMAS * measured.trend_error, SIGMAS * measured.growth_error)
        beyond = [size - max(tolerance, error) for size, error in zip(sizes, errors, strict=True)]
        is_too_short = self.conclusive and max(errors) > tolerance
        if is_too_short and max(beyond) <= 0.0 and measured.largest <= self.limit:
            beyond = [math.nan]
        return (largest, *(Comparison(excess, high=0.0) for excess in beyond))
