"""Times of short runs: by longer ones, and less what a call costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.statistics.timing import call_of, once, seconds_of
from galvi import Problem, Trajectory
from references import Contender

# Time a short run by a longer one.
#
# Nine revolutions of a rigid body take 50 microseconds of compiled code, and the overhead of a
# call, for checks and results, three times as long. The run is therefore made many times as long,
# with the same steps or tolerance, and its time divided by that factor.

TRIALS = 2  # lengths tried: from the time of the short run, then from that of a longer one


@dataclass(frozen=True)
class RepeatedRun:
    """A lengthened run.

    Attributes
    ----------
    call
        makes the run, keeping its last state
    times
        its length as a multiple of the original run
    seconds
        time of the call
    failure
        why it ended early; empty when it did not
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
    least_seconds: float,
) -> RepeatedRun:
    """A run of at least about `least` seconds, by a contender that has run before. A setting's
    ``save_every`` must be the number of steps of the original run.

    Parameters
    ----------
    seconds
        time of the run over `duration`
    """
    times = 1
    for _ in range(TRIALS):
        times = max(times, round(times * least_seconds / max(seconds, 1e-7)))
        longer = dict(setting)
        if "save_every" in longer:
            longer["save_every"] *= times
        call = call_of(contender, problem, times * duration, longer)
        run, seconds = once(call)
        if not run.success:
            return RepeatedRun(call, times, seconds, run.status)
    return RepeatedRun(call, times, seconds)


# Time a short run without what a call costs besides its steps.
#
# A run of a few hundred microseconds cannot be lengthened where its later parts would take another
# time, as in chaotic motion, or where coordinates grow that a tolerance is relative to. The run of
# one step at the same setting is timed in turn with it, and subtracted; of the steps, one is
# missing then, which the ratio n / (n - 1) makes up for.

FEWEST_REPEATS, ENOUGH_SECONDS = 5, 0.02  # repeats, fewer where they take so many seconds together
BRIEF = 1e-6  # of the duration: one step of a contender that chooses its own


@dataclass(frozen=True)
class NetTime:
    """A call whose `seconds` are those of the run less those of one step.

    Attributes
    ----------
    call
        makes the run
    short
        makes a run of one step
    steps
        of the run, 2 or more
    """

    call: Callable[[], Trajectory]
    short: Callable[[], Trajectory]
    steps: int

    @property
    def failure(self) -> str:
        """Why a run in another process failed; empty when none did."""
        return str(getattr(self.call, "failure", ""))

    def __call__(self) -> Trajectory:
        return self.call()

    def seconds(self, repeats: int) -> float:
        """Net seconds from the fastest of the repeats, since load only adds to a time: at least
        FEWEST_REPEATS unless they take more than ENOUGH_SECONDS. NaN where not positive.
        """
        runs: list[float] = []
        steps: list[float] = []
        while len(runs) < max(repeats, FEWEST_REPEATS) and sum(runs) < ENOUGH_SECONDS:
            runs.append(seconds_of(self.call))
            steps.append(seconds_of(self.short))
        run, step = min(runs), min(steps)
        net = (run - step) * self.steps / (self.steps - 1)
        return net if net > 0.0 else math.nan


def net_time(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any], steps: int
) -> NetTime:
    """The net time of a run of `steps` steps, at a setting that saves its last state only."""
    short = one_step(contender, problem, duration, setting)
    short()  # what it compiles or builds is not part of the time
    return NetTime(call_of(contender, problem, duration, setting), short, steps)


def one_step(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Callable[[], Trajectory]:
    """A call of one step of the run, whose time is what a call costs besides its steps."""
    if "save_every" in setting:
        return call_of(contender, problem, float(setting["step"]), {**setting, "save_every": 1})
    return call_of(contender, problem, BRIEF * duration, setting)
