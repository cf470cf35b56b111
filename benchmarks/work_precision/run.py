"""Run work-precision studies: errors and times of galvi's methods and of other integrators."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.measures.independent_invariants import exactly, relative_energy_error
from benchmarks.statistics.paired import written
from benchmarks.statistics.repeated_run import NetTime, net_time, one_step, repeated_run
from benchmarks.statistics.timing import (
    Timing,
    call_of,
    interleaved,
    seconds_in_turn,
    seconds_of,
    warmed,
)
from benchmarks.work_precision.asked import code_of, errors_of
from benchmarks.work_precision.dependable import dependable
from benchmarks.work_precision.fronts import fastest, front, ratios
from benchmarks.work_precision.galvi_methods import Variational
from benchmarks.work_precision.grid import refined
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
    *("error", "seconds", "seconds_low", "seconds_high", "overhead", "energy"),
    *("evaluations", "steps", "truth_error"),
)
ROUNDS, LEAST, QUICK_LEAST = 2, 0.04, 0.01  # and seconds of each setting in a round
FURTHER, LONGEST = 7, 0.7  # rounds of the settings that were chosen, and seconds of their calls
BEHIND = 3.0  # times another's seconds, at no smaller error: a round less tells that as well


@dataclass
class _Measurement:
    """One setting of one contender, with the results of its first run."""

    contender: str
    settings: str
    call: Callable[[], Trajectory]
    setting: Setting
    stops_early: bool = False
    run: Trajectory | None = None
    why: str = ""
    warm: float = field(default=0.0)
    times: int = 1  # the run's duration that the timed call covers
    rounds: str = ""
    again: str = ""
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
                  length, or largest difference of an entry; NaN for the truth itself and for a
                  failed run
    seconds       median over interleaved rounds; seconds_low and seconds_high are the fastest and
                  the slowest round. galvi's tableau, compiled kernels and MuJoCo's models are
                  prepared beforehand; building REBOUND's simulation (below a millisecond) is
                  included. For most short runs from lengthened ones, for some less those
                  of one step where steps are counted (SciPy does not), see
                  `benchmarks.statistics.repeated_run` and `net_time` there
    rounds        of a setting that is the fastest of its code at some error: seconds in each of
                  FURTHER rounds, in which it was not chosen, as text; empty for calls above LONGEST
    again         of galvi's, the same once more in these rounds: it against itself
    overhead      share of the timed call that one of one step takes, of these; where that is
                  subtracted, of what is subtracted
    energy        relative error of the energy at the end, of point masses
    evaluations   force evaluations; NaN when the engine does not count
    is_truth      whether the run is the truth itself
    status        empty; a warning about the error; or why the run failed
    reference     the truth and its accuracy
    truth_error   the truth's own error, measured like `error`
    """
    known = cases or work_precision_problems(quick)
    chosen = [case for case in known if problem in ("", case.problem.name)]
    if not chosen:
        raise ValueError(f"there is no problem {problem!r} to compare on; known: {problems(quick)}")
    tables = [
        _study(with_externals(case, externals), _least(case, quick), report, quick)
        for case in chosen
    ]
    return pd.concat(tables, ignore_index=True)


def problems(quick: bool = False) -> tuple[str, ...]:
    """The names of the work-precision problems."""
    return tuple(case.problem.name for case in work_precision_problems(quick))


def _least(case: WorkPrecisionProblem, quick: bool) -> float:
    """Seconds of each setting in a round, fewer where runs are lengthened."""
    least = QUICK_LEAST if quick else LEAST
    return 0.6 * least if case.repeated_run or case.net_time else least


def _study(
    case: WorkPrecisionProblem, least: float, report: Callable[[str], None], quick: bool
) -> pd.DataFrame:
    try:
        truth = case.truth()
    except ModuleNotFoundError as error:
        return _without_truth(case, str(error))
    measured = []
    for label, contender, settings in case.participants:
        for setting in settings:
            report(f"{case.problem.name}: {label}, {readable_setting(setting)}")
            measured.append(_first_run(case, label, contender, setting, least))
    if case.refined and not quick:
        report(f"{case.problem.name}: settings between those")
        _refine(case, measured, truth, least)
    timed = [one for one in measured if one.run is not None and one.run.success and not one.why]
    report(f"{case.problem.name}: {ROUNDS} rounds")
    timings = dict(
        zip(
            map(id, timed),
            interleaved(
                [one.call for one in timed],
                _rounds(case, timed, truth),
                least,
                [one.warm for one in timed],
                [one.times > 1 and not case.net_time for one in timed],
            ),
            strict=True,
        )
    )
    for one in timed:
        one.why = getattr(one.call, "failure", "")

    def table() -> pd.DataFrame:
        rows = [_row(case, one, truth, timings.get(id(one))) for one in measured]
        return pd.DataFrame(rows, columns=list(COLUMNS))

    report(f"{case.problem.name}: {FURTHER} rounds of the fastest")
    _time_chosen(case, measured, table(), least)
    return table()


def _refine(
    case: WorkPrecisionProblem, measured: list[_Measurement], truth: Truth, least: float
) -> None:
    """Settings where the fronts have gaps; those of a contender stay together, coarse to fine."""
    contenders = {label: contender for label, contender, _ in case.participants}
    known = {
        k: (one.contender, one.setting) for k, one in enumerate(measured) if one.run is not None
    }

    def frame() -> pd.DataFrame:
        rows = [_row(case, measured[k], truth, None) for k in known]
        seconds = [measured[k].warm / measured[k].times for k in known]
        return pd.DataFrame(rows, index=list(known)).assign(seconds=seconds)

    def add(label: str, setting: Setting) -> None:
        known[len(measured)] = (label, setting)
        try:
            measured.append(_first_run(case, label, contenders[label], setting, least))
        except ValueError as error:  # a step that it does not take
            why = str(error)
            measured.append(
                _Measurement(label, readable_setting(setting), lambda: None, setting, why=why)  # type: ignore[arg-type,return-value]
            )
            del known[len(measured) - 1]

    refined(frame, known, case.duration, add)
    order = {label: k for k, label in enumerate(contenders)}
    measured.sort(key=lambda one: order[one.contender])


def _time_chosen(
    case: WorkPrecisionProblem, measured: Sequence[_Measurement], table: pd.DataFrame, least: float
) -> None:
    """Further rounds of each code's fastest setting at each error, galvi's twice in each."""
    counted = dependable(table)
    codes = counted["contender"].map(code_of)
    chosen: dict[int, None] = {}
    for error in errors_of(counted):
        for _, runs in counted.groupby(codes, sort=False):
            best = fastest(runs, error)
            if best is not None and measured[best.name].warm <= LONGEST:
                chosen[best.name] = None
    ours = [k for k in chosen if code_of(measured[k].contender) == "galvi"]
    calls = [measured[k].call for k in (*chosen, *ours)]
    found = seconds_in_turn(calls, FURTHER, 0.5 * least)
    for k, rounds in zip((*chosen, *ours), found, strict=True):
        one = measured[k]
        text = written([seconds / one.times for seconds in rounds])
        if all(math.isfinite(seconds) for seconds in rounds):
            one.again, one.rounds = (text, one.rounds) if one.rounds else ("", text)
    for k in chosen:
        measured[k].overhead = _overhead(case, measured[k])


def _overhead(case: WorkPrecisionProblem, one: _Measurement) -> float:
    """The share of the timed call that a call of one step takes."""
    if isinstance(one.call, NetTime):
        short, whole = one.call.short, seconds_of(one.call.call)
    else:
        contender = next(c for label, c, _ in case.participants if label == one.contender)
        short = one_step(contender, case.problem, case.duration, one.setting)
        short()
        whole = one.warm
    return min(seconds_of(short) for _ in range(3)) / whole


def _rounds(case: WorkPrecisionProblem, timed: Sequence[_Measurement], truth: Truth) -> list[int]:
    """Rounds of each setting: one less where the first runs show it far behind another."""
    seen = [
        (case.distance(one.run.q[-1], truth.end), one.warm / one.times)
        for one in timed
        if one.run is not None
    ]
    return [
        ROUNDS - any(e <= error and BEHIND * s <= seconds for e, s in seen)
        for error, seconds in seen
    ]


def _first_run(
    case: WorkPrecisionProblem, label: str, contender: Contender, setting: Setting, least: float
) -> _Measurement:
    """The first run of a setting, with the call to be timed, lengthened where the case says so."""
    call = call_of(contender, case.problem, case.duration, setting)
    one = _Measurement(label, readable_setting(setting), call, setting)
    one.stops_early = isinstance(contender, Variational) and contender.stops_early(setting)
    if contender.missing:
        one.why = contender.missing
        return one
    one.run, one.warm = warmed(call)
    one.why = getattr(call, "failure", "")
    if case.repeated_run and one.run.success and not one.why:
        longer = repeated_run(contender, case.problem, case.duration, setting, one.warm, least)
        one.call, one.warm, one.times = longer.call, longer.seconds, longer.times
        one.why = longer.failure and f"Not timed, it fails later: {longer.failure}"
    steps = one.run.counts.get("steps", 0)
    if case.net_time and one.run.success and not one.why and steps > 1:
        one.call = net_time(contender, case.problem, case.duration, setting, steps)
    return one


def _without_truth(case: WorkPrecisionProblem, why: str) -> pd.DataFrame:
    """The rows of a study without measurements, when the engine of its truth is missing."""
    rows = [
        {"problem": case.problem.name, "contender": label, "settings": readable_setting(setting),
         "stops_early": False, "quantity": case.quantity, "is_truth": False, "status": why,
         "reference": why}
        for label, _, settings in case.participants
        for setting in settings
    ]  # fmt: skip
    numbers = {name: "float64" for name in NUMBERS}
    return pd.DataFrame(rows, columns=list(COLUMNS)).astype(numbers)


def _energy(case: WorkPrecisionProblem, one: _Measurement) -> float:
    if one.run is None or not isinstance(case.problem.system, NBody) or not one.run.success:
        return math.nan
    error = relative_energy_error(case.problem, exactly(one.run.q[-1]), exactly(one.run.v[-1]))
    return abs(float(np.ravel(error)[0]))


def _row(
    case: WorkPrecisionProblem, one: _Measurement, truth: Truth, timing: Timing | None
) -> dict[str, Any]:
    nan = float("nan")
    counts: Mapping[str, int] = one.run.counts if one.run is not None else {}
    error, status, is_truth = nan, one.why, False
    if one.run is not None and not one.run.success:
        status = one.run.status
    elif one.run is not None:
        is_truth = truth.source == (one.contender, one.settings)
        error = nan if is_truth else case.distance(one.run.q[-1], truth.end)
        if error < 10.0 * truth.error and not status:
            status = "The error is below ten times that of the truth: take it as a bound."
        if timing and math.isnan(timing.seconds):
            status = "Not timed: its steps took no longer than what a call costs besides them."
        status = " ".join(filter(None, (status, case.notes.get(one.contender, ""))))
    return {
        "problem": case.problem.name,
        "contender": one.contender,
        "settings": one.settings,
        "stops_early": one.stops_early,
        "quantity": case.quantity,
        "error": error,
        "seconds": timing.seconds / one.times if timing else nan,
        "seconds_low": timing.low / one.times if timing else nan,
        "seconds_high": timing.high / one.times if timing else nan,
        "rounds": one.rounds,
        "again": one.again,
        "overhead": one.overhead,
        "energy": _energy(case, one),
        "evaluations": float(counts.get("force_evaluations", nan)),
        "steps": float(counts.get("steps", nan)),
        "is_truth": is_truth,
        "status": status,
        "reference": truth.description,
        "truth_error": truth.error,
    }
