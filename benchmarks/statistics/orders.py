"""The order of a method from its errors at decreasing steps: local orders, a fit, and the reason
why the fit leaves out an error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.statistics.convergence_fits import Fit, algebraic
from galvi.arrays import Array

RESOLVED_RATIO = 10.0  # least ratio of an error to that of the truth
TRUTH_ROUNDING = 4.0 * float(np.finfo(float).eps)  # error of a truth of the size 1
LEAST_LOCAL_ORDER = 0.5  # local order below which errors no longer fall with the step
ROUND_OFF_SIZE = 1e-8  # relative error below which errors that no longer fall are round-off
FLAT_RATIO, FLAT_POINTS = 3.0, 3  # larger errors that no longer fall: ratio, least number
LEVEL_FACTOR = 4.0  # errors are fitted above this many times the largest error that no longer falls
COARSE_ERROR = 0.1  # relative error of a step that shows no order yet
BOUND = "below ten times the truth's own error: a bound"
ROUND_OFF = "round-off"
STALLED = "errors no longer fall with the step: the truth, a tolerance or a defect"
TOO_COARSE = "too coarse to show an order"
BEFORE_WINDOW = "before the window of the fit"
RULE = (
    "The order is the slope of a least-squares line through the logarithms of errors and steps. "
    "Left out are errors of a tenth of the motion or more, those below ten times the truth's own, "
    "and those within a factor of four of errors that no longer fall with the step, which is "
    "round-off where they are small. The fit takes the finest points of the rest, at least half of "
    "them: as many as give the narrowest interval. The standard error combines the scatter about "
    "the line, the choice of these points, and what the slope still changes by among them. It does "
    "not know how the errors would go on at smaller steps."
)


@dataclass(frozen=True, eq=False)
class Orders:
    """The orders of k errors, coarse to fine.

    Attributes
    ----------
    local : array, shape (k,)
        orders between each error and the one before; NaN for the first, and where one of the two is
        missing or dominated by rounding or by the truth's error
    used : array, shape (k,)
        whether the fit uses the error
    notes
        reason why the fit does not use the error; "" where it does, and for a missing error
    """

    local: Array
    fit: Fit
    used: NDArray[np.bool_]
    notes: tuple[str, ...]


def orders(
    h: Sequence[float], errors: Sequence[float], size: float = 1.0, truth_error: float = 0.0
) -> Orders:
    """The orders of errors at decreasing steps h; NaN for a failed run.

    Parameters
    ----------
    size
        size of the configurations, in the errors' unit
    truth_error
        error of the truth that the errors are measured against
    """
    steps, e = (np.asarray(x, dtype=np.float64) for x in (h, errors))
    unresolved = max(RESOLVED_RATIO * truth_error, TRUTH_ROUNDING * size)
    level, level_note = _level(steps, e, size)
    floor = max(unresolved, level)
    fit = algebraic(steps.tolist(), e.tolist(), floor=floor, ceiling=COARSE_ERROR * size)
    first, last = fit.window
    with np.errstate(invalid="ignore", divide="ignore"):
        is_above = e > floor
        used = is_above & (steps <= first * (1.0 + 1e-9)) & (steps >= last * (1.0 - 1e-9))
        slopes = np.log(e[:-1] / e[1:]) / np.log(steps[:-1] / steps[1:])
    local = np.append(np.nan, np.where(is_above[:-1] & is_above[1:], slopes, np.nan))[: e.size]
    notes = [
        ""
        if ok or np.isnan(error)
        else BOUND
        if error <= unresolved
        else level_note
        if error <= floor
        else TOO_COARSE
        if error >= COARSE_ERROR * size
        else BEFORE_WINDOW
        if fit.points
        else "fewer than three errors show an order"
        for ok, error in zip(used, e, strict=True)
    ]
    return Orders(local, fit, used, tuple(notes))


def _level(steps: Array, errors: Array, size: float) -> tuple[float, str]:
    """LEVEL_FACTOR times the level at which errors no longer fall with the step, and ROUND_OFF or
    STALLED; 0 and "" where they fall to the end."""
    is_small = errors < ROUND_OFF_SIZE * size
    for k in range(1, errors.size):
        fall = (steps[k - 1] / steps[k]) ** LEAST_LOCAL_ORDER
        finite = errors[k - 1 :][np.isfinite(errors[k - 1 :])]
        if not (errors[k - 1] > 0.0 and errors[k] * fall > errors[k - 1]):
            continue
        if is_small[k] and np.all(is_small[k:] | np.isnan(errors[k:])):
            return LEVEL_FACTOR * float(np.nanmax(errors[k:])), ROUND_OFF
        if finite.size >= FLAT_POINTS and finite.max() <= FLAT_RATIO * finite.min():
            return LEVEL_FACTOR * float(finite.max()), STALLED
    return 0.0, ""
