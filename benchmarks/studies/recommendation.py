"""Compare the promises of `galvi.recommend` with an independent truth."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.work_precision.problem import EPS, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.planets import kepler, outer_solar_system, solar_system
from references.closed_forms.kepler import KEPLER

COLUMNS = (
    "problem",
    "asked",
    "measured_over",
    "degree",
    "steps",
    "step",
    "predicted",
    "found",
    "evaluations",
    "seconds",
    "scan_seconds",
    "promise",
    "status",
)
ERRORS = (1e-4, 1e-7, 1e-10)
PART = 20  # duration over its measured part, where only a part is measured
PERIODS = 100
WITHIN = 1.1  # largest ratio of found and requested error when all was measured
EXTRAPOLATED = 3.0  # the same when it was extrapolated, or for an error proposed instead
ROUND_OFF = 100.0  # errors above this multiple of rounding must not be refused
KEPT, BROKEN = "kept", "broken"
REFUSED, GAVE_UP = "refused, rightly", "gave up too early"
EXPLANATION = (
    "galvi.recommend returns the degree and step of least time for a requested error; its choice "
    "is run and compared with the truth, the closed form or quadruple precision, to which it has "
    "no access: it compares runs with more accurate ones, over the whole duration or, in rows "
    f"marked so, over 1/{PART} of it, and extrapolates. A promise is kept "
    f"when the error at the end is at most {WITHIN:g} times the requested one, "
    f"{EXTRAPOLATED:g} times if it was extrapolated. It does not consider frames, which "
    "may be faster. An error may be refused when it is below "
    f"{ROUND_OFF:g} times the effect of rounding positions and times; the error proposed instead "
    f"must then be met within a factor of {EXTRAPOLATED:g}. Predicted is the largest error at any "
    "time of the run."
)


def recommendation_table(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    recommend: Callable[..., galvi.Recommendation] = galvi.recommend,
) -> pd.DataFrame:
    """One row for each problem, requested error and measured part of the duration.

    predicted     by the recommendation, over the whole duration
    found         largest distance of a body from the truth at the end
    evaluations   force evaluations of the run
    seconds       of the run, as the scan measured it
    scan_seconds  time of the recommendation
    promise       kept, broken, refused rightly, or given up too early
    """
    rows = []
    planets = outer_solar_system(quick), solar_system(quick)
    for case in (kepler(PERIODS, quick), from_apocentre(), *planets):
        truth = case.truth()
        for asked in ERRORS[:2] if quick else ERRORS:
            for part in (1, PART) if asked in ERRORS[:2] else (1,):
                report(f"{case.problem.name}: {asked:g}, {_said(part)}")
                rows.append(_row(case, truth, asked, part, recommend))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def from_apocentre() -> WorkPrecisionProblem:
    """Kepler, e = 0.9, from the apocentre, where steps a hundred times too long seem accurate."""
    orbit, fastest = galvi.problems.kepler(0.9), 4.4
    problem = galvi.Problem(
        orbit.system, [-1.9, 0.0], [0.0, -1.0 / math.sqrt(19.0)], name="Kepler from the apocentre"
    )
    duration = PERIODS * math.tau

    def truth() -> Truth:
        end = KEPLER.run(problem, duration, {"samples": 1}).q[-1]
        return Truth(end, 4.0 * EPS * duration * fastest, KEPLER.name)

    return WorkPrecisionProblem(problem, duration, (), truth)


def _row(
    case: WorkPrecisionProblem,
    truth: Truth,
    asked: float,
    part: int,
    recommend: Callable[..., Any],
) -> dict[str, Any]:
    measured = {} if part == 1 else {"measured": case.duration / part}
    began = time.perf_counter()
    choice = recommend(case.problem, asked, case.duration, **measured)
    took = time.perf_counter() - began
    run = galvi.integrate(
        case.problem, choice.method, choice.step, choice.steps, save_every=choice.steps
    )
    found = float(np.max(np.linalg.norm(run.q[-1] - truth.end, axis=-1)))
    return {
        "problem": case.problem.name,
        "asked": asked,
        "measured_over": _said(part),
        "degree": choice.method.space.degree,
        "steps": choice.steps,
        "step": choice.step,
        "predicted": choice.error,
        "found": found,
        "evaluations": float(np.rint(choice.evaluations)),
        "seconds": choice.seconds,
        "scan_seconds": took,
        "promise": promise(choice, found, truth.error),
        "status": choice.status,
    }


def promise(choice: galvi.Recommendation, found: float, rounding: float) -> str:
    """The outcome for the error found at the end and that of rounding alone; NaN breaks it."""
    if not choice.reached and choice.error == math.inf:
        return GAVE_UP
    exact = choice.reached and choice.measured >= choice.duration
    allowed = (WITHIN if exact else EXTRAPOLATED) * (
        choice.asked if choice.reached else choice.error
    )
    if not (math.isfinite(allowed) and found <= allowed):
        return BROKEN
    if choice.reached:
        return KEPT
    return REFUSED if choice.asked < ROUND_OFF * rounding else GAVE_UP


def _said(part: int) -> str:
    return "all of it" if part == 1 else f"1/{part}"
