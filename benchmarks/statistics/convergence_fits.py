"""Rates of convergence: least squares on logarithms, over a window chosen by one rule.

Errors are in the order of refinement, coarse to fine. The window

* ends before the first error that is at most ``floor``, the level of round-off stated by the study
  (an error that stagnates above it stays in the window and spoils the rate, as it should);
* starts after the last error of ``ceiling`` or more, which is pre-asymptotic or unstable; but such
  an error, or a failed run, after three small errors in a row is a relapse, which contradicts any
  rate;
* starts within the first half of the rest, where the standard error of the slope times Student's
  97.5 % quantile is smallest, so that a curved beginning is left out.

The uncertainty of a rate combines, as root of the sum of squares, the standard error in the chosen
window; the departure of the slopes of all windows that could have been chosen from its slope, as a
root mean square weighted by 1 / width^2; and that of the exponent of a known factor n^-power, whose
neglect would bend the line: a branch point (t - t*)^a gives coefficients of size n^(-a - 1) r^-n
(Darboux).

An order is what local slopes tend to. Where they have not settled in the window, that is, where
C h^p exp(c h) = C h^p (1 + c h + ...) fits with c beyond two of its standard errors (five points or
more), the order is its p. The uncertainty then combines the standard error of p and the distance to
the slope of the finer half; elsewhere that distance is added to the above, for three or four points
that to the last local slope. How often true orders lie within two of these uncertainties is counted
in `benchmarks.checks.coverage`.

A missing error (NaN, of a failed run) counts as large. Fewer than three points give a Fit of NaN,
which no verdict counts as success.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from galvi.arrays import Array

FEWEST_POINTS = 3
CURVED_POINTS = 5  # points from which on a curved line is fitted


@dataclass(frozen=True)
class Fit:
    """error = coefficient * n^-power * rate^n (geometric) or coefficient * h^rate (algebraic).

    Attributes
    ----------
    kind
        "geometric" or "algebraic"
    rate
        base of the geometric fit, or power of h; NaN when there is no window
    uncertainty
        standard error of the rate: scatter about the line, choice of the window, power
    window
        first and last n or h of the window, in the order of refinement
    points
        number of errors in the window
    coefficient
        error at n = 0 (times n^power) or h = 1, on the line
    stays_large
        whether there is no window because the last measured error is large
    relapse
        whether an error was large again, or a run failed, after three small errors in a row
    power
        exponent of the known factor n^-power; 0 for an algebraic fit
    bend
        c of the factor exp(c h) of an order that has not settled; 0 where it has
    slopes
        local slopes between the errors of the window of an algebraic fit, coarse to fine
    """

    kind: str
    rate: float
    uncertainty: float
    window: tuple[float, float]
    points: int
    coefficient: float
    stays_large: bool = False
    relapse: bool = False
    power: float = 0.0
    bend: float = 0.0
    slopes: tuple[float, ...] = ()

    def evaluate(self, x: Any) -> Array:
        """The fitted error at n or h, of any shape."""
        x = np.asarray(x, dtype=np.float64)
        known_factor = x**-self.power if self.power else 1.0
        algebraic_factor = x**self.rate * np.exp(self.bend * x)
        fall = known_factor * self.rate**x if self.kind == "geometric" else algebraic_factor
        return self.coefficient * fall


@dataclass(frozen=True)
class Decay:
    """The decay of errors with n.

    Attributes
    ----------
    fit
        the geometric fit
    early, late
        geometric fits to the coarse and the fine half of the window
    worst
        the largest ratio of successive errors inside the window
    smallest
        the smallest error; NaN when there is none
    """

    fit: Fit
    early: Fit
    late: Fit
    worst: float
    smallest: float


def decay(n: Sequence[float], errors: Sequence[float], *, floor: float) -> Decay:
    """The decay of errors at increasing n, above the round-off level `floor`."""
    smallest = float(np.min(errors)) if len(errors) else float("nan")
    return Decay(
        geometric(n, errors, floor=floor),
        *halves(n, errors, floor=floor),
        worst_ratio(errors, floor=floor),
        smallest,
    )


def geometric(
    n: Sequence[float],
    errors: Sequence[float],
    *,
    floor: float,
    ceiling: float = 0.1,
    power: tuple[float, float] = (0.0, 0.0),
) -> Fit:
    """Fit error = C n^-g rate^n to errors at increasing n, positive where g is not 0.

    The module's docstring defines the window and the uncertainty.

    Parameters
    ----------
    power
        g and its standard error
    """
    x = np.asarray(n, dtype=np.float64)
    exponent, exponent_error = power
    fit = _best_window(x, errors, floor, ceiling, exponent)
    if fit is None:
        return replace(_none("geometric", errors, ceiling), power=exponent)
    slope, spread, constant, window, points = fit
    if exponent_error:
        inside = x[(window[0] <= x) & (x <= window[1])]
        spread = float(np.hypot(spread, exponent_error * _line(inside, np.log(inside))[0]))
    base = float(np.exp(slope))
    constant, has_relapse = float(np.exp(constant)), relapses(errors, ceiling)
    return Fit(
        "geometric",
        base,
        base * spread,
        window,
        points,
        constant,
        relapse=has_relapse,
        power=exponent,
    )


def algebraic(
    h: Sequence[float], errors: Sequence[float], *, floor: float, ceiling: float = 0.1
) -> Fit:
    """Fit error = C h^rate to errors at positive, decreasing h.

    The module's docstring defines the window and the uncertainty.
    """
    h = np.asarray(h, dtype=np.float64)
    fit = _best_window(np.log(h), errors, floor, ceiling)
    if fit is None:
        return _none("algebraic", errors, ceiling)
    slope, spread, constant, (first, last), points = fit
    inside = (last <= np.log(h)) & (np.log(h) <= first)
    x, y = np.log(h[inside]), np.log(np.asarray(errors, dtype=np.float64)[inside])
    half = (points + 1) // 2 if points >= CURVED_POINTS else 2
    finer_slope = float(np.polyfit(x[-half:], y[-half:], 1)[0])
    bend, p, error, log_coefficient = _unsettled_order(x, y)
    if bend:
        slope, spread, constant = p, error, log_coefficient
    slopes = tuple((np.diff(y) / np.diff(x)).tolist())
    return Fit(
        "algebraic",
        slope,
        float(np.hypot(spread, finer_slope - slope)),
        (float(np.exp(first)), float(np.exp(last))),
        points,
        float(np.exp(constant)),
        relapse=relapses(errors, ceiling),
        bend=bend,
        slopes=slopes,
    )


def halves(
    n: Sequence[float], errors: Sequence[float], *, floor: float, ceiling: float = 0.1
) -> tuple[Fit, Fit]:
    """Geometric fits to the coarse and the fine half of the errors between floor and ceiling.

    For an odd number of points both halves contain the middle one.
    """
    allowed = window(errors, floor=floor, ceiling=ceiling)
    x, e = np.asarray(n, dtype=np.float64)[allowed], np.asarray(errors, dtype=np.float64)[allowed]
    half = (x.size + 1) // 2
    if half < FEWEST_POINTS:
        return (_none("geometric", errors, ceiling),) * 2
    parts = []
    for part in (slice(None, half), slice(x.size - half, None)):
        slope, spread, constant = _line(x[part], np.log(e[part]))
        ends = (float(x[part][0]), float(x[part][-1]))
        base = float(np.exp(slope))
        parts.append(Fit("geometric", base, base * spread, ends, half, float(np.exp(constant))))
    return parts[0], parts[1]


def slope(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of the least-squares line through the logarithms of all errors and sizes."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def worst_ratio(errors: Sequence[float], *, floor: float, ceiling: float = 0.1) -> float:
    """The largest ratio of successive errors inside the window; NaN with fewer than 3 errors."""
    e = np.asarray(errors, dtype=np.float64)[window(errors, floor=floor, ceiling=ceiling)]
    return float(np.max(e[1:] / e[:-1])) if e.size >= FEWEST_POINTS else float("nan")


def relapses(errors: Sequence[float], ceiling: float = 0.1) -> bool:
    """Whether an error of ``ceiling`` or more, or a missing one, follows three smaller ones in a
    row."""
    small_count = 0
    for error in errors:
        is_small = error < ceiling
        if small_count >= FEWEST_POINTS and not is_small:
            return True
        small_count = small_count + 1 if is_small else 0
    return False


def window(errors: Sequence[float], *, floor: float, ceiling: float = 0.1) -> slice:
    """The range of errors for a fit: it ends before the first error of at most ``floor``, and
    starts after the last one before that of ``ceiling`` or more."""
    e = np.asarray(errors, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        tiny = np.flatnonzero(e <= floor)
        end = int(tiny[0]) if tiny.size else e.size
        large = np.flatnonzero(~(e[:end] < ceiling))
    return slice(int(large[-1]) + 1 if large.size else 0, end)


def _best_window(
    x: Array, errors: Sequence[float], floor: float, ceiling: float, power: float = 0.0
) -> Any:
    """The line log error + power log x = intercept + slope x in the best window.

    Returns (slope, its uncertainty, intercept, (first, last) x, points); None with fewer than three
    points. ValueError unless x is strictly monotone.
    """
    from scipy.special import stdtrit  # a quarter of a second

    if x.size and np.any(np.diff(x) * np.sign(x[-1] - x[0]) <= 0.0):
        raise ValueError("n must increase, or h decrease, from each error to the next.")
    allowed = window(errors, floor=floor, ceiling=ceiling)
    x, e = x[allowed], np.asarray(errors, dtype=np.float64)[allowed]
    if x.size < FEWEST_POINTS:
        return None
    y = np.log(e) + (power * np.log(x) if power else 0.0)
    starts = range(x.size - max(FEWEST_POINTS, (x.size + 1) // 2) + 1)
    lines = np.array([_line(x[start:], y[start:]) for start in starts])
    slopes, spreads, constants = lines.T
    points = x.size - np.array(starts)
    widths = np.maximum(spreads * stdtrit(points - 2, 0.975), np.finfo(float).tiny)
    k = int(np.argmin(widths))
    variance = np.average((slopes - slopes[k]) ** 2, weights=(widths[k] / widths) ** 2)
    uncertainty = float(np.hypot(spreads[k], np.sqrt(variance)))
    ends = float(x[starts[k]]), float(x[-1])
    return float(slopes[k]), uncertainty, float(constants[k]), ends, int(points[k])


def _unsettled_order(x: Array, y: Array) -> tuple[float, float, float, float]:
    """Fit y = a + p x + c exp(x); returns c, p, the standard error of p, and a.

    All are 0 with fewer than CURVED_POINTS points, or where c is within two of its standard errors.
    """
    if x.size < CURVED_POINTS:
        return 0.0, 0.0, 0.0, 0.0
    columns = np.stack([np.ones_like(x), x, np.exp(x - x[0])], axis=1)
    (a, p, c), *_ = np.linalg.lstsq(columns, y, rcond=None)
    residuals = y - columns @ [a, p, c]
    covariance = np.linalg.inv(columns.T @ columns) * (residuals @ residuals) / (x.size - 3)
    if not abs(c) > 2.0 * np.sqrt(covariance[2, 2]):
        return 0.0, 0.0, 0.0, 0.0
    return float(c * np.exp(-x[0])), float(p), float(np.sqrt(covariance[1, 1])), float(a)


def _line(x: Array, y: Array) -> tuple[float, float, float]:
    """Slope, its standard error and intercept of the line through (x, y)."""
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    constant = float(y.mean() - slope * x.mean())
    residuals = y - (constant + slope * x)
    spread = float(np.sqrt(residuals @ residuals / (x.size - 2) / (centred @ centred)))
    return slope, spread, constant


def _none(kind: str, errors: Sequence[float], ceiling: float) -> Fit:
    nan, e = float("nan"), np.asarray(errors, dtype=np.float64)
    finite = e[np.isfinite(e)]
    stays_large = bool(finite.size >= FEWEST_POINTS and finite[-1] >= ceiling)
    return Fit(kind, nan, nan, (nan, nan), 0, nan, stays_large, relapses(errors, ceiling))
