"""Times of short runs: by longer runs, or without the overhead of a call."""

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

LENGTHENINGS = 2  # the second from the time of the first lengthened run


@dataclass(frozen=True)
class RepeatedRun:
    """A lengthened run.

    Attributes
    ----------
    call
        a call of the run, which saves its last state
    times
        duration of the run as a multiple of the original one
    seconds
        time of the call
    failure
        reason why the run ended early; "" where it did not
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
    """A run of about `least_seconds` or more, by a contender that has run before.

    A setting's ``save_every`` must be the number of steps of the original run.

    Parameters
    ----------
    seconds
        time of the run over `duration`
    """
    times = 1
    for _ in range(LENGTHENINGS):
        times = max(times, round(times * least_seconds / max(seconds, 1e-7)))
        longer = dict(setting)
        if "save_every" in longer:
            longer["save_every"] *= times
        call = call_of(contender, problem, times * duration, longer)
        run, seconds = once(call)
        if not run.success:
            return RepeatedRun(call, times, seconds, run.status)
    return RepeatedRun(call, times, seconds)


# Time a short run without the overhead of its call.
#
# A run of a few hundred microseconds cannot be lengthened where its later parts would take another
# time, as in chaotic motion, or where coordinates grow that a tolerance is relative to. A run of
# one step at the same setting is timed in turn with it and subtracted. The difference is the time
# of n - 1 steps, so it is multiplied by n / (n - 1).

FEWEST_REPEATS, ENOUGH_SECONDS = 5, 0.02  # repeats, fewer where they take longer than this
ONE_STEP_FRACTION = 1e-6  # of the duration: a run of one step by a contender that chooses its steps


@dataclass(frozen=True)
class NetTime:
    """A call whose `seconds` are those of the run less those of one step.

    Attributes
    ----------
    call
        a call of the run
    short
        a call of a run of one step
    steps
        number of steps of the run, 2 or more
    """

    call: Callable[[], Trajectory]
    short: Callable[[], Trajectory]
    steps: int

    @property
    def failure(self) -> str:
        """The reason why a run in another process failed; "" where none did."""
        return str(getattr(self.call, "failure", ""))

    def __call__(self) -> Trajectory:
        return self.call()

    def seconds(self, repeats: int) -> float:
        """Net seconds of the fastest repeats, since load only adds to a time; NaN where not
        positive.

        There are at least FEWEST_REPEATS repeats, fewer where the runs take ENOUGH_SECONDS.
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
    short()  # so that the timed calls do not compile
    return NetTime(call_of(contender, problem, duration, setting), short, steps)


def one_step(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Callable[[], Trajectory]:
    """A call of a run of one step, to measure the overhead of a call."""
    if "save_every" in setting:
        return call_of(contender, problem, float(setting["step"]), {**setting, "save_every": 1})
    return call_of(contender, problem, ONE_STEP_FRACTION * duration, setting)
