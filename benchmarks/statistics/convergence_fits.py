"""Rates of convergence: least squares on logarithms, over a window chosen by one rule.

Errors are in the order of refinement, coarse to fine. The window

* ends before the first error that is at most ``floor``, the level of round-off stated by the study
  (an error that stagnates above it stays in the window and spoils the rate, as it should);
* starts after the last error of ``ceiling`` or more, which is pre-asymptotic or unstable; but such
  an error, or a failed run, after three small errors in a row is a relapse, which contradicts any
  rate;
* starts within the first half of the rest, where the standard error of the slope times Student's
  97.5 % quantile is smallest, so that a curved beginning is left out.

A missing error (NaN, of a failed run) counts as large. Fewer than three points give a Fit of NaN,
which no verdict counts as success.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from galvi.arrays import Array

LEAST = 3


@dataclass(frozen=True)
class Fit:
    """error = coefficient * rate^n (geometric) or coefficient * h^rate (algebraic).

    kind         "geometric" or "algebraic"
    rate         base of n, or power of h; NaN when there is no window
    uncertainty  its standard error, from the scatter about the line
    window       first and last n or h of the window, in the order of refinement
    points       number of errors in the window
    coefficient  error at n = 0 or h = 1, on the line
    stays_large  there is no window because the measured errors did not become small
    relapse      small errors became large again, or a run failed
    """

    kind: str
    rate: float
    uncertainty: float
    window: tuple[float, float]
    points: int
    coefficient: float
    stays_large: bool = False
    relapse: bool = False

    def evaluate(self, x: Any) -> Array:
        """The fitted error at n or h, of any shape."""
        x = np.asarray(x, dtype=np.float64)
        power = self.rate**x if self.kind == "geometric" else x**self.rate
        line: Array = self.coefficient * power
        return line


@dataclass(frozen=True)
class Decay:
    """The decay of errors with n.

    fit          the geometric fit
    early, late  geometric fits to the coarse and the fine half of the window
    worst        the largest ratio of successive errors inside the window
    smallest     the smallest error; NaN when there is none
    """

    fit: Fit
    early: Fit
    late: Fit
    worst: float
    smallest: float


def decay(n: Sequence[float], errors: Sequence[float], *, floor: float) -> Decay:
    """The decay of errors at increasing n."""
    smallest = float(np.min(errors)) if len(errors) else float("nan")
    return Decay(
        geometric(n, errors, floor=floor),
        *halves(n, errors, floor=floor),
        worst_ratio(errors, floor=floor),
        smallest,
    )


def geometric(
    n: Sequence[float], errors: Sequence[float], *, floor: float, ceiling: float = 0.1
) -> Fit:
    """Fit error = C rate^n; n increasing. The module's docstring defines the window."""
    fit = _best(np.asarray(n, dtype=np.float64), errors, floor, ceiling)
    if fit is None:
        return _none("geometric", errors, ceiling)
    slope, spread, constant, window, points = fit
    base = float(np.exp(slope))
    constant, back = float(np.exp(constant)), relapses(errors, ceiling)
    return Fit("geometric", base, base * spread, window, points, constant, relapse=back)


def algebraic(
    h: Sequence[float], errors: Sequence[float], *, floor: float, ceiling: float = 0.1
) -> Fit:
    """Fit error = C h^rate; h positive, decreasing. The module's docstring defines the window."""
    h = np.asarray(h, dtype=np.float64)
    fit = _best(np.log(h), errors, floor, ceiling)
    if fit is None:
        return _none("algebraic", errors, ceiling)
    slope, spread, constant, (first, last), points = fit
    window = (float(np.exp(first)), float(np.exp(last)))
    constant, back = float(np.exp(constant)), relapses(errors, ceiling)
    return Fit("algebraic", slope, spread, window, points, constant, relapse=back)


def halves(
    n: Sequence[float], errors: Sequence[float], *, floor: float, ceiling: float = 0.1
) -> tuple[Fit, Fit]:
    """Geometric fits to the coarse and the fine half of the errors between floor and ceiling.

    For an odd number of points both halves contain the middle one.
    """
    allowed = window(errors, floor=floor, ceiling=ceiling)
    x, e = np.asarray(n, dtype=np.float64)[allowed], np.asarray(errors, dtype=np.float64)[allowed]
    half = (x.size + 1) // 2
    if half < LEAST:
        return (_none("geometric", errors, ceiling),) * 2
    parts = []
    for part in (slice(None, half), slice(x.size - half, None)):
        slope, spread, constant = _line(x[part], np.log(e[part]))
        ends = (float(x[part][0]), float(x[part][-1]))
        base = float(np.exp(slope))
        parts.append(Fit("geometric", base, base * spread, ends, half, float(np.exp(constant))))
    return parts[0], parts[1]


def worst_ratio(errors: Sequence[float], *, floor: float, ceiling: float = 0.1) -> float:
    """The largest ratio of successive errors inside the window; NaN with fewer than 3 errors."""
    e = np.asarray(errors, dtype=np.float64)[window(errors, floor=floor, ceiling=ceiling)]
    return float(np.max(e[1:] / e[:-1])) if e.size >= LEAST else float("nan")


def relapses(errors: Sequence[float], ceiling: float = 0.1) -> bool:
    """Whether an error of ``ceiling`` or more, or a missing one, follows three small ones."""
    run = 0
    for error in errors:
        small = error < ceiling
        if run >= LEAST and not small:
            return True
        run = run + 1 if small else 0
    return False


def window(errors: Sequence[float], *, floor: float, ceiling: float = 0.1) -> slice:
    """The range of errors for a fit: above round-off, and small from its start on."""
    e = np.asarray(errors, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        tiny = np.flatnonzero(e <= floor)
        end = int(tiny[0]) if tiny.size else e.size
        large = np.flatnonzero(~(e[:end] < ceiling))
    return slice(int(large[-1]) + 1 if large.size else 0, end)


def _best(x: Array, errors: Sequence[float], floor: float, ceiling: float) -> Any:
    """(slope, its standard error, intercept, (first, last) x, points) of the best window."""
    if x.size and np.any(np.diff(x) * np.sign(x[-1] - x[0]) <= 0.0):
        raise ValueError("n must increase, or h decrease, from each error to the next.")
    allowed = window(errors, floor=floor, ceiling=ceiling)
    x, e = x[allowed], np.asarray(errors, dtype=np.float64)[allowed]
    best, narrowest = None, np.inf
    for start in range(0, x.size - max(LEAST, (x.size + 1) // 2) + 1):
        slope, spread, constant = _line(x[start:], np.log(e[start:]))
        points = x.size - start
        width = spread * float(student.ppf(0.975, points - 2))
        if width < narrowest:
            narrowest = width
            best = slope, spread, constant, (float(x[start]), float(x[-1])), points
    return best


def _line(x: Array, y: Array) -> tuple[float, float, float]:
    """Slope, its standard error and intercept of the line through (x, y)."""
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    constant = float(y.mean() - slope * x.mean())
    rest = y - (constant + slope * x)
    spread = float(np.sqrt(rest @ rest / (x.size - 2) / (centred @ centred)))
    return slope, spread, constant


def _none(kind: str, errors: Sequence[float], ceiling: float) -> Fit:
    nan, e = float("nan"), np.asarray(errors, dtype=np.float64)
    finite = e[np.isfinite(e)]
    stays_large = bool(finite.size >= LEAST and finite[-1] >= ceiling)
    return Fit(kind, nan, nan, (nan, nan), 0, nan, stays_large, relapses(errors, ceiling))
