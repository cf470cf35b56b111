"""Time a short run by a longer one.

Nine revolutions of a rigid body take 50 microseconds of compiled code, and the overhead of a call,
for checks and results, three times as long. The run is therefore made many times as long, with the
same steps or tolerance, and its time divided by that factor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.statistics.timing import call_of, once
from galvi import Problem, Trajectory
from references import Contender

TRIALS = 2  # lengths tried: from the time of the short run, then from that of a longer one


@dataclass(frozen=True)
class RepeatedRun:
    """A lengthened run.

    call     makes the run, keeping its last state
    times    its length as a multiple of the original run
    seconds  time of the call
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
    """A run of at least about `least` seconds, by a contender that has run before. A setting's
    ``save_every`` must be the number of steps of the original run.

    seconds  time of the run over `duration`
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
