"""Statistics of the series in a tidy table: orders, bases, decays, drifts and extremes.

``where`` selects the rows of a series by column, e.g. study="n-refinement".
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from benchmarks.statistics import convergence_fits
from benchmarks.statistics import drift as drifts
from benchmarks.statistics.convergence_fits import Decay, Fit
from benchmarks.statistics.drift import Drift
from benchmarks.store.tables import pick, series
from galvi.arrays import Array


def order(table: pd.DataFrame, floor: float, until: float = np.inf, **where: Any) -> Fit:
    """The fitted order of a series of errors in the step, at steps of `until` or less."""
    h, errors = series(table, "step", **where)
    return convergence_fits.algebraic(h[h <= until], errors[h <= until], floor=floor)


def power(table: pd.DataFrame, floor: float, **where: Any) -> Fit:
    """The fitted power of 1 / N in a series of errors in n = N + 1."""
    n, errors = series(table, "n", **where)
    return convergence_fits.algebraic(1.0 / (n - 1.0), errors, floor=floor)


def base(
    table: pd.DataFrame,
    floor: float,
    since: float = 0.0,
    power: tuple[float, float] = (0.0, 0.0),
    **where: Any,
) -> Fit:
    """The fitted base of a series of errors in n, from n = since on, beside a known factor n^-g;
    `power` is g and its standard error."""
    n, errors = series(table, "n", **where)
    late = n >= since
    return convergence_fits.geometric(n[late], errors[late], floor=floor, power=power)


def decay(table: pd.DataFrame, floor: float, since: float = 0.0, **where: Any) -> Decay:
    """The decay of a series of errors in n, from n = since on."""
    n, errors = series(table, "n", **where)
    return convergence_fits.decay(n[n >= since], errors[n >= since], floor=floor)


def drift(table: pd.DataFrame, **where: Any) -> Drift:
    """The drift of a series of errors in time."""
    rows = pick(table, **where).sort_values("t")
    return drifts.drift(rows["t"].to_numpy(), rows["value"].to_numpy())


def values(table: pd.DataFrame, by: str = "", **where: Any) -> Array:
    """The values of these rows, sorted by the column `by` if given."""
    rows = pick(table, **where)
    return (rows.sort_values(by) if by else rows)["value"].to_numpy(np.float64)


def largest(numbers: Array) -> float:
    """The largest number; NaN when one is NaN or there are none."""
    return float(np.max(numbers)) if len(numbers) else float("nan")


def smallest(numbers: Array) -> float:
    """The least number; NaN when one is NaN or there are none."""
    return float(np.min(numbers)) if len(numbers) else float("nan")


def largest_of(table: pd.DataFrame, **where: Any) -> float:
    """The largest value of these rows."""
    return largest(values(table, **where))


def smallest_of(table: pd.DataFrame, **where: Any) -> float:
    """The least value of these rows."""
    return smallest(values(table, **where))
