"""The bound of a regression test, from differences between runs that differ by rounding alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from benchmarks.applications.releases.behaviour import CHANGE_FLOORS
from galvi.arrays import Array

# The measurements behind FEWEST_FLOORS and MOST_FLOORS are printed by
# pytest -m slow -s tests/suite/benchmarks/test_tolerance.py -k limits
UPPER_QUANTILE = 0.95  # the spread is that between the median and this quantile
TAIL_DEVIATIONS = 4.0  # standard deviations to which the tail is extrapolated
FEWEST_FLOORS = 5.0  # least number of floors of a bound
MOST_FLOORS = CHANGE_FLOORS / 2.0  # a run within such a bound, displaced by FLOORS, is outside
FEWEST_ULPS = 4.0  # ulp of the size: no floor is smaller
LARGEST_LOGARITHM = 700.0  # of a factor
CHAOS_FRACTION = 1e-3  # of the motion: a larger floor is no longer rounding

FAILED = "runs from starts moved by rounding fail"
CHAOS = "rounding has grown to more than a thousandth of the motion"
SPREAD = (
    "a few runs differ far more than the others, as where rounding decides whether bodies touch, "
    "and a bound that holds for all of them would miss faults"
)


@dataclass(frozen=True)
class Bound:
    """The bound of a quantity at a time.

    Attributes
    ----------
    floor
        largest measured difference by rounding; infinite where a run failed
    factor
        ratio of the bound to the floor; NaN where a run failed
    median
        median of the differences, of which each counts as at least FEWEST_ULPS ulp; NaN where a run
        failed
    reason
        reason why there is no bound; "" where there is one
    """

    floor: float
    factor: float
    median: float
    reason: str = ""

    @property
    def value(self) -> float:
        """The bound; NaN where there is none."""
        return math.nan if self.reason else self.factor * self.floor


def bound_of(differences: Array, ulp: float, motion: float) -> Bound:
    """The bound that holds for runs which differ by rounding alone, and not for a fault of
    CHANGE_FLOORS floors.

    Parameters
    ----------
    differences : array, shape (runs,)
        largest difference of an entry of each run from the plain run
    ulp
        ulp of the size of the quantity; differences below FEWEST_ULPS ulp count as that many
    motion
        extent of the quantity's motion; 0 where that is unknown

    Notes
    -----
    The tail is that of a log-normal distribution with the median and upper quantile measured.
    """
    if not np.isfinite(differences).all():
        return Bound(math.inf, math.nan, math.nan, FAILED)
    smallest = max(FEWEST_ULPS * ulp, float(np.finfo(float).tiny))
    median, upper, floor = np.quantile(
        np.maximum(differences, smallest), (0.5, UPPER_QUANTILE, 1.0)
    ).tolist()
    exponent = math.log(upper / median) * TAIL_DEVIATIONS / NormalDist().inv_cdf(UPPER_QUANTILE)
    factor = max(
        FEWEST_FLOORS, math.exp(min(math.log(median / floor) + exponent, LARGEST_LOGARITHM))
    )
    if motion and floor > max(CHAOS_FRACTION * motion, smallest):
        return Bound(floor, factor, median, CHAOS)
    return Bound(floor, factor, median, SPREAD if factor > MOST_FLOORS else "")
