"""Work-precision studies: what an error costs, for galvi's methods and for the peers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from benchmarks.statistics.repeated_run import repeated_run
from benchmarks.statistics.timing import Timing, call_of, interleaved, warmed
from benchmarks.work_precision.fronts import TRUTH, front, ratios
from benchmarks.work_precision.participants import Participant, readable_setting, with_externals
from benchmarks.work_precision.problem import Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems import arenas
from galvi import Trajectory

__all__ = ["COLUMNS", "front", "problems", "ratios", "work_precision"]

COLUMNS = (
    "problem",
    "contender",
    "settings",
    "quantity",
    "error",
    "seconds",
    "seconds_low",
    "seconds_high",
    "evaluations",
    "steps",
    "status",
    "reference",
)
ROUNDS = 3


@dataclass
class _Entry:
    """One setting of one contender, with what its first run left."""

    contender: str
    settings: str
    call: Callable[[], Trajectory]
    run: Trajectory | None = None
    why: str = ""
    warm: float = field(default=0.0)
    times: int = 1  # the run's duration that the timed call covers


def work_precision(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    externals: Sequence[Participant] = (),
    problem: str = "",
) -> pd.DataFrame:
    """One row for each problem, contender and setting; external integrators take part where
    they can.

    Given the name of a problem, of that one alone. Raises ValueError when there is no such problem.

    quantity      whose error it is: position, attitude or angle
    error         largest distance of a body from the truth at the end, in the problem's unit of
                  length, or largest entry of R - R_truth; NaN for the truth itself and for a run
                  that failed
    seconds       median over rounds in which all settings take their turn; seconds_low and
                  seconds_high are the fastest and the slowest round. galvi's table, the compiled
                  kernels and MuJoCo's models are ready; building REBOUND's simulation (below a
                  millisecond) is included. Of rigid bodies, from runs that go on: see
                  `benchmarks.statistics.repeated_run`
    evaluations   of the force at one configuration; NaN when the engine does not count
    status        empty; 'truth'; a warning about the error; or why the run failed
    reference     the truth, and how far it can be trusted
    """
    known = arenas(quick)
    chosen = [arena for arena in known if problem in ("", arena.problem.name)]
    if not chosen:
        raise ValueError(f"there is no problem {problem!r} to compare on; known: {problems(quick)}")
    tables = [
        _study(with_externals(arena, externals), _least(arena, quick), report) for arena in chosen
    ]
    return pd.concat(tables, ignore_index=True)


def problems(quick: bool = False) -> tuple[str, ...]:
    """The names of those that contenders are compared on."""
    return tuple(arena.problem.name for arena in arenas(quick))


def _least(arena: WorkPrecisionProblem, quick: bool) -> float:
    """Seconds of each setting's turn in a round; less where runs are made that long."""
    least = 0.01 if quick else 0.12
    return 0.5 * least if arena.repeated_run else least


def _study(
    arena: WorkPrecisionProblem, least: float, report: Callable[[str], None]
) -> pd.DataFrame:
    try:
        truth = arena.truth()
    except ModuleNotFoundError as error:
        return _without_truth(arena, str(error))
    entries = []
    for label, contender, settings in arena.entries:
        for setting in settings:
            report(f"{arena.problem.name}: {label}, {readable_setting(setting)}")
            entry = _Entry(
                label,
                readable_setting(setting),
                call_of(contender, arena.problem, arena.duration, setting),
            )
            if contender.missing:
                entry.why = contender.missing
            else:
                entry.run, entry.warm = warmed(entry.call)
                entry.why = getattr(entry.call, "failure", "")
            if arena.repeated_run and entry.run is not None and entry.run.success and not entry.why:
                longer = repeated_run(
                    contender, arena.problem, arena.duration, setting, entry.warm, least
                )
                entry.call, entry.warm, entry.times = longer.call, longer.seconds, longer.times
                entry.why = longer.failure and f"Not timed, it fails later: {longer.failure}"
            entries.append(entry)
    timed = [e for e in entries if e.run is not None and e.run.success and not e.why]
    report(f"{arena.problem.name}: {ROUNDS} rounds")
    timings = dict(
        zip(
            map(id, timed),
            interleaved([e.call for e in timed], ROUNDS, least, [e.warm for e in timed]),
            strict=True,
        )
    )
    for entry in timed:
        entry.why = getattr(entry.call, "failure", "")
    return pd.DataFrame(
        [_row(arena, entry, truth, timings.get(id(entry))) for entry in entries],
        columns=list(COLUMNS),
    )


def _without_truth(arena: WorkPrecisionProblem, why: str) -> pd.DataFrame:
    """The study's rows when the engine of its truth is absent: nothing was measured."""
    rows = [
        {"problem": arena.problem.name, "contender": label, "settings": readable_setting(setting),
         "quantity": arena.quantity, "status": why, "reference": why}
        for label, _, settings in arena.entries
        for setting in settings
    ]  # fmt: skip
    numbers = {name: "float64" for name in COLUMNS[4:10]}
    return pd.DataFrame(rows, columns=list(COLUMNS)).astype(numbers)


def _row(
    arena: WorkPrecisionProblem, entry: _Entry, truth: Truth, timing: Timing | None
) -> dict[str, Any]:
    nan = float("nan")
    counts: Mapping[str, int] = entry.run.counts if entry.run is not None else {}
    error, status = nan, entry.why
    if entry.run is not None and not entry.run.success:
        status = entry.run.status
    elif entry.run is not None and truth.is_from(entry.contender):
        status = TRUTH
    elif entry.run is not None:
        error = arena.distance(entry.run.q[-1], truth.end)
        if error < 10.0 * truth.error and not status:
            status = "The error is below ten times that of the truth: take it as a bound."
    return {
        "problem": arena.problem.name,
        "contender": entry.contender,
        "settings": entry.settings,
        "quantity": arena.quantity,
        "error": error,
        "seconds": timing.seconds / entry.times if timing else nan,
        "seconds_low": timing.low / entry.times if timing else nan,
        "seconds_high": timing.high / entry.times if timing else nan,
        "evaluations": float(counts.get("force_evaluations", nan)),
        "steps": float(counts.get("steps", nan)),
        "status": status,
        "reference": truth.description,
    }
