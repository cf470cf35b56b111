"""Cost at a given error, interpolated between measured steps."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.statistics.estimate import Estimate
from galvi.arrays import Array


def cost_at(level: float, costs: Array, errors: Array, standard_errors: Array) -> Estimate:
    """The cost from which on the magnitude of the errors stays at or below a level.

    Parameters
    ----------
    costs : array, shape (k,)
        increasing costs
    errors : array, shape (k,)
        signed errors
    standard_errors : array, shape (k,)
        standard errors of the errors

    Notes
    -----
    The logarithm of the cost is interpolated linearly in the error, between the last point above
    the level and the next. The uncertainty is that of the errors. NaN where the last point is above
    the level or missing, all are at or below it, or the last point above is missing.
    """
    above = np.flatnonzero(~(np.abs(errors) <= level))
    if not above.size or above[-1] == len(errors) - 1:
        return Estimate(math.nan)
    k = above[-1]
    sign, fall = np.sign(errors[k]), errors[k] - errors[k + 1]
    fraction = (errors[k] - sign * level) / fall
    slope = math.log(costs[k + 1] / costs[k]) / abs(fall)
    cost = costs[k] * (costs[k + 1] / costs[k]) ** fraction
    error = (
        cost
        * slope
        * math.hypot((1.0 - fraction) * standard_errors[k], fraction * standard_errors[k + 1])
    )
    return Estimate(float(cost), float(error))


def ratio_of(first: Estimate, second: Estimate) -> Estimate:
    """The ratio of two estimates whose errors are independent."""
    ratio = first.value / second.value
    errors = ((estimate.uncertainty or 0.0) / estimate.value for estimate in (first, second))
    return Estimate(ratio, ratio * math.hypot(*errors))
