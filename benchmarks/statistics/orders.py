"""The order of a method from its errors at decreasing steps: local orders, a fit, and why the
fit leaves out an error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.statistics.convergence_fits import Fit, algebraic
from galvi.arrays import Array

RESOLVED = 10.0  # least ratio of an error to that of the truth
ROUNDING = 4.0 * float(np.finfo(float).eps)  # error of a truth of the size 1
STILL = 0.5  # local order below which errors no longer fall with the step
SMALL = 1e-8  # relative error below which they are round-off then
FLAT, FLAT_POINTS = 3.0, 3  # ratio and number of larger errors that no longer fall
CLEAR = 4.0  # errors over the largest of those, which bend their line less
COARSE = 0.1  # relative error of a step that shows no order yet
BOUND = "below ten times the truth's own error: a bound"
ROUND_OFF = "round-off"
STALLED = "errors no longer fall with the step: the truth, a tolerance or a defect"
TOO_COARSE = "too coarse to show an order"
BEFORE = "before the window of the fit"
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
        no error of the method
    used
        (k,) whether the fit uses the error
    notes
        why the fit does not use the error; "" where it does
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
        of the configurations, in the errors' unit
    truth_error
        of the truth that they are measured against
    """
    steps, e = (np.asarray(x, dtype=np.float64) for x in (h, errors))
    unresolved = max(RESOLVED * truth_error, ROUNDING * size)
    level, still = _level(steps, e, size)
    floor = max(unresolved, level)
    fit = algebraic(steps.tolist(), e.tolist(), floor=floor, ceiling=COARSE * size)
    first, last = fit.window
    with np.errstate(invalid="ignore", divide="ignore"):
        above = e > floor
        used = above & (steps <= first * (1.0 + 1e-9)) & (steps >= last * (1.0 - 1e-9))
        slopes = np.log(e[:-1] / e[1:]) / np.log(steps[:-1] / steps[1:])
    local = np.append(np.nan, np.where(above[:-1] & above[1:], slopes, np.nan))[: e.size]
    notes = [
        ""
        if ok or np.isnan(error)
        else BOUND
        if error <= unresolved
        else still
        if error <= floor
        else TOO_COARSE
        if error >= COARSE * size
        else BEFORE
        if fit.points
        else "fewer than three errors show an order"
        for ok, error in zip(used, e, strict=True)
    ]
    return Orders(local, fit, used, tuple(notes))


def _level(steps: Array, errors: Array, size: float) -> tuple[float, str]:
    """CLEAR times the level at which errors no longer fall with the step, and what that is; 0
    where they fall to the end."""
    small = errors < SMALL * size
    for k in range(1, errors.size):
        fall = (steps[k - 1] / steps[k]) ** STILL
        finite = errors[k - 1 :][np.isfinite(errors[k - 1 :])]
        if not (errors[k - 1] > 0.0 and errors[k] * fall > errors[k - 1]):
            continue
        if small[k] and np.all(small[k:] | np.isnan(errors[k:])):
            return CLEAR * float(np.nanmax(errors[k:])), ROUND_OFF
        if finite.size >= FLAT_POINTS and finite.max() <= FLAT * finite.min():
            return CLEAR * float(finite.max()), STALLED
    return 0.0, ""
