"""Order and cost tables: methods on one problem at decreasing steps, for `galvi.convergence`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.measures.defects import kept_components, largest_changes, map_symplecticity_defect
from benchmarks.statistics.orders import BOUND, RESOLVED_RATIO, orders
from benchmarks.statistics.repeated_run import repeated_run
from benchmarks.statistics.timing import Timing, call_of, interleaved, warmed
from benchmarks.work_precision.galvi_methods import InClock, Variational
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import Participant, Setting, Truth
from benchmarks.work_precision.truths import (
    Report,
    accurate_motion,
    measure_of,
    size_of,
    state_distance,
)
from galvi import Problem, Trajectory
from galvi.arrays import Array

COLUMNS = (
    "method", "h", "error", "order", "fitted", "fitted_se", "energy", "momentum", "symmetry",
    "symplecticity", "seconds", "evaluations", "outcome", "setting", "steps", "fit", "theory",
    "note",
)  # fmt: skip
STATES = 128  # largest number of states of equal steps at which invariants are compared
TIMING_ROUNDS = 3
ROUND_SECONDS, QUICK_ROUND_SECONDS = 0.05, 0.01  # of a setting in each round
COMPLETED, FAILED = "completed", "failed"
ORDER_DISTANCE = 0.25  # of an order from the theoretical one
TRUTH_NOTE = "the truth"  # note of the run that is the truth


@dataclass
class _Measured:
    """A setting of a participant, with its run and, later, its time."""

    participant: Participant
    setting: Setting
    run: Trajectory
    call: Any
    warm_seconds: float
    repeats: int = 1
    timing: Timing | None = None
    failure: str = ""


def order_table(
    problem: Problem,
    duration: float,
    participants: Sequence[Participant],
    truth: Truth,
    quick: bool,
    report: Report,
) -> pd.DataFrame:
    """A row for each participant and setting, coarse to fine.

    method         the participant's label
    h              the step, in the unit of time or of the method's clock; NaN for a code that
                   chooses its own
    error          of the state at the end, see `benchmarks.work_precision.truths.state_distance`
    order          between this error and the one before
    fitted         the order fitted to the rows with `fit`; fitted_se its standard error; see
                   `benchmarks.statistics.orders.RULE`
    energy         largest change at up to STATES states, at all steps in a clock and at the end
                   alone for a code that chooses its steps, relative to its size; NaN where the
                   motion does not conserve it
    momentum       the same for the components of angular and linear momentum that the motion
                   conserves
    symmetry       distance from the start after the run and another back from its end
    symplecticity  defect of one step from the start, relative
    seconds        median of interleaved rounds, of runs that are lengthened where they are short
                   and the motion keeps its energy, so that later parts take as long
    evaluations    number of evaluations of the force; NaN where the code does not count
    outcome        completed or failed
    setting        the setting as text; steps: the number of steps; fit: whether the fit uses the
                   row
    theory         the method's theoretical or declared order; NaN where it is unknown
    note           reason why the fit does not use the row, or why the run failed
    """
    motion = accurate_motion(problem, duration, truth)
    conserved = {} if motion is None else kept_components(motion)
    is_lengthened = bool(conserved.get("energy", np.array([False]))[0])
    measured = []
    for participant in participants:
        for setting in participant.settings:
            report(f"{participant.label}, {readable_setting(setting)}")
            measured.append(
                _first_run(problem, duration, participant, setting, is_lengthened, quick)
            )
    report("times")
    _time(measured, quick)
    error_of = state_distance(problem, (truth.end, truth.momenta), motion)
    rows = []
    for measurement in measured:
        report(
            f"{measurement.participant.label}, {readable_setting(measurement.setting)}: structure"
        )
        row = _row(problem, duration, measurement, conserved)
        if truth.source == (measurement.participant.contender.name, row["setting"]):
            row["note"] = TRUTH_NOTE
        elif measurement.run.success:
            row["error"] = error_of((measurement.run.q[-1], measurement.run.p[-1]))
        rows.append(row)
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    return _with_orders(table, size_of(problem, truth.end), truth.error)


def remarks(table: pd.DataFrame) -> list[str]:
    """A sentence for each method whose fitted order differs from the theoretical one by more than
    ORDER_DISTANCE and five standard errors."""
    sentences = []
    for name, rows in table.groupby("method", sort=False):
        order, error, theory = rows[["fitted", "fitted_se", "theory"]].iloc[0]
        if abs(order - theory) > max(ORDER_DISTANCE, 5.0 * error):
            sentences.append(
                f"{name} has the order {theory:g} at small steps, by theory, and {order:.2f} at "
                "these: they may be too long, or its error small by chance at this end."
            )
    return sentences


def _first_run(
    problem: Problem,
    duration: float,
    participant: Participant,
    setting: Setting,
    is_lengthened: bool,
    quick: bool,
) -> _Measured:
    """Run a setting; returns its run, with states in between, and a call to time, without these.

    Parameters
    ----------
    is_lengthened
        whether a short run is timed by a longer one, since its later parts take as long
    """
    contender = participant.contender
    call = call_of(contender, problem, duration, setting)
    last, warm_seconds = warmed(call)
    measured = _Measured(participant, setting, last, call, warm_seconds)
    if not last.success:
        measured.failure = last.status
        return measured
    with_states = _with_states(contender, setting)
    if with_states is not setting:
        run = contender.run(problem, duration, with_states)
        if run.success:
            measured.run = replace(run, counts=last.counts)
    if is_lengthened:
        least_seconds = QUICK_ROUND_SECONDS if quick else ROUND_SECONDS
        longer = repeated_run(contender, problem, duration, setting, warm_seconds, least_seconds)
        if not longer.failure:
            measured.call, measured.warm_seconds, measured.repeats = (
                longer.call,
                longer.seconds,
                longer.times,
            )
    return measured


def _with_states(contender: Any, setting: Setting) -> Setting:
    """The setting that saves states at up to STATES step ends, in a clock at all.

    The setting itself for a code that chooses its steps, as it interpolates states in between.
    """
    if isinstance(contender, InClock):
        return {"step": setting["step"], "save_every": 1}
    if "step" not in setting:
        return setting
    count = setting["save_every"]
    save_every = next(k for k in range(1, count + 1) if count % k == 0 and count // k <= STATES)
    return {**setting, "save_every": save_every}


def _time(measured: Sequence[_Measured], quick: bool) -> None:
    timed = [measurement for measurement in measured if not measurement.failure]
    timings = interleaved(
        [measurement.call for measurement in timed],
        TIMING_ROUNDS,
        QUICK_ROUND_SECONDS if quick else ROUND_SECONDS,
        [measurement.warm_seconds for measurement in timed],
        [measurement.repeats > 1 for measurement in timed],
    )
    for measurement, timing in zip(timed, timings, strict=True):
        measurement.timing = timing


def _row(
    problem: Problem, duration: float, measurement: _Measured, conserved: Mapping[str, Array]
) -> dict[str, Any]:
    """All columns but the error and the orders."""
    run, contender, counts = (
        measurement.run,
        measurement.participant.contender,
        measurement.run.counts,
    )
    has_equal_steps = "step" in measurement.setting
    row: dict[str, Any] = {
        "method": measurement.participant.label,
        "h": measurement.setting["step"] if has_equal_steps else math.nan,
        "outcome": COMPLETED if run.success else FAILED,
        "setting": readable_setting(measurement.setting),
        "theory": _theory(contender, measurement.setting) if has_equal_steps else math.nan,
        "steps": float(counts.get("steps", measurement.setting.get("save_every", math.nan))),
        "evaluations": float(counts.get("force_evaluations", math.nan)),
        "seconds": measurement.timing.seconds / measurement.repeats
        if measurement.timing
        else math.nan,
        "note": measurement.failure,
    }
    if not run.success:
        return row
    row["energy"], row["momentum"] = largest_changes(run, conserved)
    if isinstance(contender, InClock):
        row["symmetry"] = _or_nan(
            galvi.round_trip_error,
            problem,
            contender.method,
            measurement.setting["step"],
            len(run.t) - 1,
        )
    elif has_equal_steps:
        row["symmetry"] = _round_trip(problem, duration, measurement)
    if has_equal_steps:
        row["symplecticity"] = _symplecticity(problem, measurement)
    return row


def _theory(contender: Any, setting: Setting) -> float:
    """The theoretical or declared order of a method; with further options in its setting, the
    option "order". NaN if unknown."""
    if isinstance(contender, InClock):
        return float(contender.method.order)
    if setting.keys() - {"step", "save_every"}:
        return float(setting.get("order", math.nan))
    return float(getattr(contender, "order", None) or math.nan)


def _or_nan(measure: Callable[..., float], *arguments: Any) -> float:
    """The value of a measure; NaN where it raises ValueError."""
    try:
        return measure(*arguments)
    except ValueError:
        return math.nan


def _round_trip(problem: Problem, duration: float, measurement: _Measured) -> float:
    """Distance from the start after a run back from the end; NaN where that fails."""
    _, distance = measure_of(problem)
    contender: Any = measurement.participant.contender
    setting = {**measurement.setting, "step": -measurement.setting["step"]}
    run = measurement.run
    back = replace(problem, q0=run.q[-1], v0=run.v[-1], t0=problem.t0 + duration)

    def distance_from_start() -> float:
        # `trial`: a failure here is no fault of the integrator
        returned = getattr(contender, "trial", contender.run)(back, -duration, setting)
        return distance(returned.q[-1], problem.q0) if returned.success else math.nan

    return _or_nan(distance_from_start)


def _symplecticity(problem: Problem, measurement: _Measured) -> float:
    """The defect of a step from the start, by differences of runs; NaN where it is not defined.

    In clocks, whose phase space includes the time, and in frames, where runs take longer, it is
    galvi's own.
    """
    contender, h = measurement.participant.contender, measurement.setting["step"]
    if isinstance(contender, InClock) or (
        isinstance(contender, Variational) and contender.method.in_frame
    ):
        return _or_nan(galvi.symplecticity_defect, problem, contender.method, h)
    single = {**measurement.setting, "save_every": 1}

    def step(start: Problem) -> tuple[Any, Any]:
        run = contender.run(start, h, single)
        return run.q[-1], run.p[-1]

    return _or_nan(map_symplecticity_defect, problem, step)


def _with_orders(table: pd.DataFrame, size: float, truth_error: float) -> pd.DataFrame:
    """The table with the columns fit, order, fitted and fitted_se of each method's equal steps."""
    table["fit"] = False
    table[["order", "fitted", "fitted_se"]] = np.nan
    is_bound = (
        table["h"].isna() & (table["error"] <= RESOLVED_RATIO * truth_error) & (table["note"] == "")
    )
    table.loc[is_bound, "note"] = BOUND
    for _, rows in table.groupby("method", sort=False):
        fine = rows[rows["h"].notna()].sort_values("h", ascending=False)
        if fine.empty:
            continue
        series = orders(list(fine["h"]), list(fine["error"]), size, truth_error)
        table.loc[fine.index, "order"] = series.local
        table.loc[fine.index, "fit"] = series.used
        table.loc[fine.index, "fitted"] = series.fit.rate
        table.loc[fine.index, "fitted_se"] = series.fit.uncertainty
        notes = table.loc[fine.index, "note"].where(fine["note"] != "", list(series.notes))
        table.loc[fine.index, "note"] = notes
    return table
