"""The bound of a regression test, from how far apart equal runs are that round otherwise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from benchmarks.applications.releases.behaviour import FLOORS
from galvi.arrays import Array

# Chosen on 17 runs of models (pendulums, arms, a top, boxes and balls in contact, orbits by four
# integrators), each from 2,000 starts, of which 64 drawn at random made a bound and all were tried
# on it. Log-normal tails from the 75th, 90th and 95th percentile, exponential tails, those from the
# largest and a quantile, and constants were tried; this one had among the fewest false alarms and
# times without a bound. With 2 in place of LEAST, bouncing balls, some of whose runs part by eight
# medians once in 400, had 255 false alarms in a million; with 4 nine, with 5 none. Starts were
# moved by 2 ulp of the start then, not of the run, and differences taken as at least one ulp.
UPPER = 0.95  # quantile that gives the spread, with the median
DEVIATIONS = 4.0  # to which the tail is extrapolated
LEAST = 5.0  # floors that a bound has
MOST = FLOORS / 2.0  # a run within such a bound, displaced by FLOORS, is outside
FEW = 4.0  # ulp of the size, below which no floor is
LARGEST = 700.0  # logarithm of a factor
EATEN = 1e-3  # share of the motion, above which a floor is no longer rounding

FAILED = "runs from neighbouring starts fail"
CHAOS = "rounding has grown to more than a thousandth of the motion"
SPREAD = (
    "some runs are much further apart than most, as where rounding decides on a contact or a step, "
    "and a bound for all of them would miss faults"
)


@dataclass(frozen=True)
class Bound:
    """Of one quantity at one time.

    Attributes
    ----------
    floor
        what rounding is measured to move; infinite where a run failed
    factor
        floors that hold the tail; NaN where a run failed
    reason
        why there is no bound; "" where there is one
    """

    floor: float
    factor: float
    reason: str = ""

    @property
    def value(self) -> float:
        """The bound, NaN for none."""
        return math.nan if self.reason else self.factor * self.floor


def bound_of(differences: Array, ulp: float, motion: float) -> Bound:
    """The bound that runs which differ by rounding alone keep, and a fault of FLOORS floors does
    not.

    Parameters
    ----------
    differences : array, shape (runs,)
        the largest of an entry of each run from the plain one
    ulp
        of the size of the quantity; differences below FEW are taken as these
    motion
        how far the quantity moves

    Notes
    -----
    The tail is that of a log-normal distribution with the median and upper quantile measured.
    """
    if not np.isfinite(differences).all():
        return Bound(math.inf, math.nan, FAILED)
    least = max(FEW * ulp, float(np.finfo(float).tiny))
    median, upper, floor = np.quantile(np.maximum(differences, least), (0.5, UPPER, 1.0)).tolist()
    exponent = math.log(upper / median) * DEVIATIONS / NormalDist().inv_cdf(UPPER)
    factor = max(LEAST, math.exp(min(math.log(median / floor) + exponent, LARGEST)))
    if floor > max(EATEN * motion, least):
        return Bound(floor, factor, CHAOS)
    return Bound(floor, factor, SPREAD if factor > MOST else "")
