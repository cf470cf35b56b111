"""The time of a short run, taken from one that goes on long enough for a stopwatch.

A rigid body turns nine times in 50 microseconds of compiled code, and a call needs three times as
long to check what it was given and to build what it returns. The same steps, or tolerance, are
therefore kept up for many times the duration, and the time is divided by that number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.statistics.timing import call_of, once
from galvi import Problem, Trajectory
from references import Contender

TRIALS = 2  # lengths tried: by the short run's time, then by a longer one's


@dataclass(frozen=True)
class RepeatedRun:
    """A run made longer.

    call     makes it, keeping its last state
    times    as long as the run that it stands for
    seconds  it took
    failure  why it did not come to its end; empty when it did
    """

    call: Callable[[], Trajectory]
    times: int
    seconds: float
    failure: str = ""


def repeated_run(
    contender: Contender,
    problem: Problem,
    duration: float,
    setting: Mapping[str, Any],
    seconds: float,
    least: float,
) -> RepeatedRun:
    """A run of about ``least`` seconds, by a contender that has run before. Its setting's
    ``save_every``, when it has one, is a whole run's number of steps.

    seconds  of the run over `duration`
    """
    times = 1
    for _ in range(TRIALS):
        times = max(times, round(times * least / max(seconds, 1e-7)))
        longer = dict(setting)
        if "save_every" in longer:
            longer["save_every"] *= times
        call = call_of(contender, problem, times * duration, longer)
        run, seconds = once(call)
        if not run.success:
            return RepeatedRun(call, times, seconds, run.status)
    return RepeatedRun(call, times, seconds)
