"""Are the Galerkin curves as good as the step ends? The scan of T for L2 and L6.

H prints no T in chapter 3. The errors of the ends grow with T, the curve's own does not: the two
agree for as many n as T is long enough.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.claims.lie_groups.pendulum_motion import TRUTH
from benchmarks.measures.refinement import Case, method_on_group, refine
from benchmarks.statistics import readings
from benchmarks.store.frames import pick
from galvi import Problem
from references import Contender

ENDS, CURVE = "one-step error", "curve error"
ORACLES = "distance between the two references"
STEP, DURATIONS, NS = 0.5, (5.0, 50.0, 500.0), range(3, 11)
SAME = 2.0  # "the same error": one line in a plot over ten decades
BOTH = "the Galerkin curves have the same error as the one-step map"
WHY = (
    "The errors of the steps add up in time, the curve's own error inside a step does not: until "
    "the ends' error falls below it, both errors are the ends', as H suspects. The longer the run, "
    "the more n that takes; H prints no T."
)
POWER = (
    "The ends' error grows in proportion to T, the curve's own not at all: their ratio is of size "
    "1 / T where the curve is behind."
)


def scan_of(duration: float, what: str = "") -> str:
    """The study of one duration."""
    return f"{what}curves and ends, T = {duration:g}"


def scan(
    problem: Problem, make_method: MakeMethod, report: Report, what: str = ""
) -> list[dict[str, Any]]:
    """Series of both errors in n for each of DURATIONS, in Cayley's chart, against DOP853."""
    found = []
    for duration in DURATIONS:
        cases = [Case(n, STEP, round(duration / STEP)) for n in NS]
        options = (make_method, report, method_on_group)
        found += refine(scan_of(duration, what), problem, TRUTH, cases, (ENDS, CURVE), *options)
    return found


def between(problem: Problem, duration: float, second: Contender, **setting: Any) -> float:
    """Largest entry of the difference of the scan's truth and a second one, at 100 times."""
    samples = {"samples": 100}
    exact, other = (
        TRUTH.run(problem, duration, samples),
        second.run(problem, duration, {**samples, **setting}),
    )
    return float(np.max(np.abs(exact.q - other.q)))


def largest_ratio(table: pd.DataFrame, duration: float, up_to: int, what: str = "") -> float:
    """The largest ratio of curve to one-step error, for n up to `up_to`."""
    return readings.largest(np.array([ratio(table, duration, n, what) for n in NS if n <= up_to]))


def ratio(table: pd.DataFrame, duration: float, n: int, what: str = "") -> float:
    """Curve error over one-step error; NaN where one is missing."""
    study = scan_of(duration, what)
    both = [pick(table, study=study, n=n, quantity=name)["value"] for name in (CURVE, ENDS)]
    return float(both[0].iloc[0] / both[1].iloc[0]) if all(map(len, both)) else float("nan")


def power(table: pd.DataFrame, n: int, what: str = "") -> float:
    """p of ratio = C T^-p, between the shortest and the longest of DURATIONS."""
    first, last = (ratio(table, duration, n, what) for duration in (DURATIONS[0], DURATIONS[-1]))
    return float(np.log(first / last) / np.log(DURATIONS[-1] / DURATIONS[0]))


def listed(durations: Iterable[float] = DURATIONS) -> str:
    """The durations in words."""
    return ", ".join(f"{duration:g}" for duration in durations)
