"""The time of a short run, measured on a longer one.

Nine revolutions of a rigid body take 50 microseconds of compiled code, and a call three times as
long to check its arguments and to build its result. The run is therefore made many times as long,
with the same steps or tolerance, and its time is divided by that number.
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
    times    its length in units of the run that it stands for
    seconds  of the call
    failure  why it ended early; empty when it did not
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
