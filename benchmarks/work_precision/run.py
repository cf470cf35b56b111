"""Run work-precision studies: errors and times of galvi's methods and of other integrators."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.measures.independent_invariants import exactly, relative_energy_error
from benchmarks.statistics.paired import written
from benchmarks.statistics.repeated_run import NetTime, net_time, one_step, repeated_run
from benchmarks.statistics.timing import call_of, seconds_in_turn, seconds_of, warmed
from benchmarks.work_precision.asked import code_of, errors_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import fastest, front, ratios
from benchmarks.work_precision.galvi_methods import Variational
from benchmarks.work_precision.grid import add_settings
from benchmarks.work_precision.participants import (
    ExternalContender,
    readable_setting,
    with_externals,
)
from benchmarks.work_precision.problem import Setting, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems import work_precision_problems
from galvi import NBody, Trajectory
from references import Contender

__all__ = ["COLUMNS", "front", "problems", "ratios", "work_precision"]

COLUMNS = (
    "problem",
    "contender",
    "settings",
    "stops_early",
    "quantity",
    "error",
    "error_is_bound",
    "own_error",
    "seconds",
    "seconds_low",
    "seconds_high",
    "rounds",
    "again",
    "overhead",
    "energy",
    "evaluations",
    "steps",
    "is_truth",
    "status",
    "reference",
    "truth_error",
)
NUMBERS = (
    *("error", "own_error", "seconds", "seconds_low", "seconds_high", "overhead", "energy"),
    *("evaluations", "steps", "truth_error"),
)
ROUND_SECONDS, QUICK_ROUND_SECONDS = 0.012, 0.005  # seconds of each setting in a round
ROUNDS = 7
BOUND_REMARK = "Its error is a bound: the truth tells no smaller one, ten times its own."


@dataclass
class _Measurement:
    """One setting of one contender, with its first run and its times."""

    contender: str
    settings: str
    call: Callable[[], Trajectory]
    setting: Setting
    stops_early: bool = False
    run: Trajectory | None = None
    failure: str = ""
    warm_seconds: float = 0.0
    repeats: int = 1  # the run's duration that the timed call covers
    rounds: list[float] = field(default_factory=list)
    repeated_rounds: list[float] = field(default_factory=list)
    overhead: float = math.nan


def work_precision(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    externals: Sequence[ExternalContender] = (),
    problem: str = "",
    cases: Sequence[WorkPrecisionProblem] = (),
) -> pd.DataFrame:
    """One row for each problem, contender and setting; external integrators take part where
    they can.

    With the name of a problem, for that one only; with ``cases`` for these in place of the suite's.
    Raises ValueError when there is no such problem.

    stops_early   whether galvi's iteration may end before it has converged
    quantity      the quantity of the error: position, attitude, angle, coordinates or attitude and
                  place
    error         largest distance of a body from the truth at the end, in the problem's unit of
                  length, or largest difference of an entry, as it counts in `dependable`; NaN for
                  the truth itself and for a failed run
    error_is_bound  whether the error is what the truth resolves: the run's is at most that
    own_error     that of the run alone
    seconds       median over `rounds`; seconds_low and seconds_high are the fastest and the slowest
                  round. galvi's tableau, compiled kernels and MuJoCo's models are prepared
                  beforehand; building REBOUND's simulation (below a millisecond) is included. For
                  most short runs from lengthened ones, for some less those of one step where steps
                  are counted (SciPy does not), see `benchmarks.statistics.repeated_run` and
                  `net_time` there
    rounds        seconds in each round, as text. All settings of a problem take turns in ROUNDS
                  rounds, long runs in the first of them alone
    again         of galvi's settings the same once more in these rounds: it against itself
    overhead      of settings that are the fastest of their code at an error: the share of the timed
                  call that one of one step takes; where that is subtracted, of what is subtracted
    energy        relative error of the energy at the end, of point masses
    evaluations   force evaluations; NaN when the engine does not count
    is_truth      whether the run is the truth itself
    status        empty; a warning about the error; or why the run failed
    reference     the truth and its accuracy
    truth_error   the truth's own error, measured like `error`
    """
    suite = cases or work_precision_problems(quick)
    chosen = [case for case in suite if problem in ("", case.problem.name)]
    if not chosen:
        raise ValueError(f"there is no problem {problem!r} to compare on; known: {problems(quick)}")
    tables = [_study(with_externals(case, externals), report, quick) for case in chosen]
    return pd.concat(tables, ignore_index=True)


def problems(quick: bool = False) -> tuple[str, ...]:
    """The names of the work-precision problems."""
    return tuple(case.problem.name for case in work_precision_problems(quick))


def _study(case: WorkPrecisionProblem, report: Callable[[str], None], quick: bool) -> pd.DataFrame:
    round_seconds = QUICK_ROUND_SECONDS if quick else ROUND_SECONDS
    try:
        truth = case.truth()
    except ModuleNotFoundError as error:
        return _without_truth(case, str(error))
    measured = []
    for label, contender, settings in case.participants:
        for setting in settings:
            report(f"{case.problem.name}: {label}, {readable_setting(setting)}")
            measured.append(_first_run(case, label, contender, setting, round_seconds))
    if not quick:
        report(f"{case.problem.name}: settings between those")
        _refine(case, measured, truth, round_seconds)
    report(f"{case.problem.name}: {ROUNDS} rounds")
    _time(measured, round_seconds)
    table = _table(case, measured, truth)
    for k in _fastest_of_codes(table):
        measured[k].overhead = _overhead(case, measured[k])
    return table.assign(overhead=[measurement.overhead for measurement in measured])


def _refine(
    case: WorkPrecisionProblem, measured: list[_Measurement], truth: Truth, round_seconds: float
) -> None:
    """Add settings where the fronts have gaps; those of a contender stay together."""
    contenders = {label: contender for label, contender, _ in case.participants}
    settings = {
        k: (measurement.contender, measurement.setting)
        for k, measurement in enumerate(measured)
        if measurement.run is not None
    }

    def current_rows() -> pd.DataFrame:
        rows = [_row(case, measured[k], truth) for k in settings]
        seconds = [measured[k].warm_seconds / measured[k].repeats for k in settings]
        return pd.DataFrame(rows, index=list(settings)).assign(seconds=seconds)

    def add(label: str, setting: Setting) -> None:
        settings[len(measured)] = (label, setting)
        try:
            measured.append(_first_run(case, label, contenders[label], setting, round_seconds))
        except ValueError as error:  # a step that it does not take
            reason = str(error)
            measured.append(
                _Measurement(
                    label, readable_setting(setting), lambda: None, setting, failure=reason
                )  # type: ignore[arg-type,return-value]
            )
            del settings[len(measured) - 1]

    add_settings(current_rows, settings, case.duration, add)
    order = {label: k for k, label in enumerate(contenders)}
    measured.sort(key=lambda measurement: order[measurement.contender])


def _time(measured: Sequence[_Measurement], round_seconds: float) -> None:
    """Time all settings in turn, those of galvi twice in each round."""
    timed = [
        measurement
        for measurement in measured
        if measurement.run is not None and measurement.run.success and not measurement.failure
    ]
    by_galvi = [measurement for measurement in timed if code_of(measurement.contender) == "galvi"]
    samples = seconds_in_turn(
        [measurement.call for measurement in (*timed, *by_galvi)], ROUNDS, round_seconds
    )
    seconds = [
        [call / measurement.repeats for call in calls]
        for measurement, calls in zip((*timed, *by_galvi), samples, strict=True)
    ]
    for measurement, rounds in zip(timed, seconds[: len(timed)], strict=True):
        measurement.rounds, measurement.failure = rounds, getattr(measurement.call, "failure", "")
    for measurement, rounds in zip(by_galvi, seconds[len(timed) :], strict=True):
        measurement.repeated_rounds = rounds


def _fastest_of_codes(table: pd.DataFrame) -> set[Any]:
    """Indices of the rows that are the fastest of their code at an error of `errors_of`."""
    codes = [runs for _, runs in table.groupby(table["contender"].map(code_of), sort=False)]
    best = [fastest(runs, error) for error in errors_of(table) for runs in codes]
    return {row.name for row in best if row is not None}


def _overhead(case: WorkPrecisionProblem, measurement: _Measurement) -> float:
    """The share of the timed call that a call of one step takes."""
    if isinstance(measurement.call, NetTime):
        short, full_seconds = measurement.call.short, seconds_of(measurement.call.call)
    else:
        contender = next(c for label, c, _ in case.participants if label == measurement.contender)
        short = one_step(contender, case.problem, case.duration, measurement.setting)
        short()
        full_seconds = measurement.warm_seconds
    return min(seconds_of(short) for _ in range(3)) / full_seconds


def _first_run(
    case: WorkPrecisionProblem,
    label: str,
    contender: Contender,
    setting: Setting,
    round_seconds: float,
) -> _Measurement:
    """The first run of a setting, with the call to be timed, lengthened where the case says so."""
    call = call_of(contender, case.problem, case.duration, setting)
    measurement = _Measurement(label, readable_setting(setting), call, setting)
    measurement.stops_early = isinstance(contender, Variational) and contender.stops_early(setting)
    if contender.missing:
        measurement.failure = contender.missing
        return measurement
    measurement.run, measurement.warm_seconds = warmed(call)
    measurement.failure = getattr(call, "failure", "")
    if case.repeated_run and measurement.run.success and not measurement.failure:
        longer = repeated_run(
            contender, case.problem, case.duration, setting, measurement.warm_seconds, round_seconds
        )
        measurement.call, measurement.warm_seconds, measurement.repeats = (
            longer.call,
            longer.seconds,
            longer.times,
        )
        measurement.failure = longer.failure and f"Not timed, it fails later: {longer.failure}"
    steps = measurement.run.counts.get("steps", 0)
    if case.net_time and measurement.run.success and not measurement.failure and steps > 1:
        measurement.call = net_time(contender, case.problem, case.duration, setting, steps)
    return measurement


def _without_truth(case: WorkPrecisionProblem, reason: str) -> pd.DataFrame:
    """The rows of a study without measurements, as the engine of its truth is missing."""
    rows = [
        {
            "problem": case.problem.name,
            "contender": label,
            "settings": readable_setting(setting),
            "stops_early": False,
            "quantity": case.quantity,
            "error_is_bound": False,
            "is_truth": False,
            "status": reason,
            "reference": reason,
        }
        for label, _, settings in case.participants
        for setting in settings
    ]
    numbers = {name: "float64" for name in NUMBERS}
    return pd.DataFrame(rows, columns=list(COLUMNS)).astype(numbers)


def _energy(case: WorkPrecisionProblem, measurement: _Measurement) -> float:
    if (
        measurement.run is None
        or not isinstance(case.problem.system, NBody)
        or not measurement.run.success
    ):
        return math.nan
    error = relative_energy_error(
        case.problem, exactly(measurement.run.q[-1]), exactly(measurement.run.v[-1])
    )
    return abs(float(np.ravel(error)[0]))


def _table(
    case: WorkPrecisionProblem, measured: Sequence[_Measurement], truth: Truth
) -> pd.DataFrame:
    """The rows, with the errors that count."""
    rows = pd.DataFrame([_row(case, measurement, truth) for measurement in measured])
    table = dependable(rows)[list(COLUMNS)]
    remark = (BOUND_REMARK + " " + table["status"]).str.strip()
    return table.assign(status=table["status"].mask(table["error_is_bound"], remark))


def _row(case: WorkPrecisionProblem, measurement: _Measurement, truth: Truth) -> dict[str, Any]:
    nan = float("nan")
    counts: Mapping[str, int] = measurement.run.counts if measurement.run is not None else {}
    rounds = (
        measurement.rounds if all(math.isfinite(seconds) for seconds in measurement.rounds) else []
    )
    error, status, is_truth = nan, measurement.failure, False
    if measurement.run is not None and not measurement.run.success:
        status = measurement.run.status
    elif measurement.run is not None:
        is_truth = truth.source == (measurement.contender, measurement.settings)
        error = nan if is_truth else case.distance(measurement.run.q[-1], truth.end)
        if measurement.rounds and not rounds:
            status = "Not timed: its steps took no longer than what a call costs besides them."
        status = " ".join(filter(None, (status, case.notes.get(measurement.contender, ""))))
    return {
        "problem": case.problem.name,
        "contender": measurement.contender,
        "settings": measurement.settings,
        "stops_early": measurement.stops_early,
        "quantity": case.quantity,
        "error": error,
        "seconds": statistics.median(rounds) if rounds else nan,
        "seconds_low": min(rounds, default=nan),
        "seconds_high": max(rounds, default=nan),
        "rounds": written(rounds),
        "again": written(measurement.repeated_rounds if rounds else []),
        "overhead": measurement.overhead,
        "energy": _energy(case, measurement),
        "evaluations": float(counts.get("force_evaluations", nan)),
        "steps": float(counts.get("steps", nan)),
        "is_truth": is_truth,
        "status": status,
        "reference": truth.description,
        "truth_error": truth.error,
    }
