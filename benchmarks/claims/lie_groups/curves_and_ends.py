"""The scan of the duration T for L2 and L6: are the Galerkin curves as good as the step ends?

H prints no T in chapter 3. The errors at the ends grow with T, but the excess of the curve's does
not: therefore the two errors agree up to an n that grows with T.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    Array,
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    method_on_group,
    refine,
    series,
)
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH

ENDS, CURVE = ENDS_AND_CURVE
DURATIONS, NS = (5.0, 50.0, 500.0), range(3, 11)


def scan_of(duration: float, prefix: str = "") -> str:
    """The study of one duration."""
    return f"{prefix}curves and ends, T = {duration:g}"


def scan(problem: Problem, make_method: MakeMethod, report: Report, prefix: str = "") -> list[Any]:
    """Series of both errors in n for each of DURATIONS, in steps of 0.5 and Cayley's chart."""
    rows = []
    for duration in DURATIONS:
        cases = [Case(n, 0.5, round(duration / 0.5)) for n in NS]
        options = (cases, ENDS_AND_CURVE, make_method, report, method_on_group)
        rows += refine(scan_of(duration, prefix), problem, TRUTH, *options)
    return rows


def n_stars(table: DataFrame, prefix: str = "", key: str = "law") -> dict[str, Measurement]:
    """The measured n* of all DURATIONS but the shortest, and, as numbers `law_50` and so on, their
    predictions: the excess of the curve's error, as measured at T = 5, falls like 5 / T."""
    excess = {duration: excess_of_curve(table, scan_of(duration, prefix)) for duration in DURATIONS}
    numbers: dict[str, Measurement] = {}
    for duration in DURATIONS[1:]:
        name = f"n*, up to which the curves are as good as the ends, {prefix}T = {duration:g}"
        numbers[name] = crossing(excess[duration])
        numbers[f"{key}_{duration:g}"] = crossing(excess[5.0] * 5.0 / duration)
    return numbers


def excess_of_curve(table: DataFrame, study: str) -> Array:
    """The curve's error over that of the ends, less 1, for each of NS."""
    ends, curve = (series(table, "n", study=study, quantity=name)[1] for name in ENDS_AND_CURVE)
    return curve / ends - 1.0


def crossing(excess: Array) -> float:
    """The n, interpolated between two of NS, at which the excess reaches 1.

    NaN if it does so at no n, at the first one, or after a value that is not positive.
    """
    k = next((k for k, size in enumerate(excess) if size >= 1.0), 0)
    if k == 0 or excess[k - 1] <= 0.0:
        return math.nan
    below, beyond = np.log(excess[k - 1 : k + 1])
    return float(NS[k - 1] - below / (beyond - below))
