"""Comparable times of several calls: warmed up, in interleaved rounds, with an interval.

The time of a run by another engine is that of the engine, without the conversion of its states. A
call in another process is timed there: it has ``seconds(repeats)``, the mean over that many calls,
and ``seconds_of_last_call``.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from galvi import Problem, Trajectory
from references import Contender
from references.engine_clock import timed_engines

ROUND_PARTS = 3
LONG_SECONDS, LONG_ROUNDS = 0.3, 2  # a call that takes longer is timed in so many rounds
EVERY_ROUND_SECONDS = 1.0  # longest call that `seconds_in_turn` makes in every round


def call_of(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Callable[[], Trajectory]:
    """A call that runs the contender: its ``timed`` run, if the contender measures times itself."""
    timed = getattr(contender, "timed", None)
    if timed is not None:
        return timed(problem, duration, setting)
    return partial(contender.run, problem, duration, setting)


@dataclass(frozen=True)
class Timing:
    """Seconds of one call: the median over the rounds, the fastest and the slowest round."""

    seconds: float
    low: float
    high: float


def interleaved(
    calls: Sequence[Callable[[], Any]],
    rounds: int,
    least_seconds: float,
    warm: Sequence[float] | None = None,
    counted: Sequence[bool] | None = None,
) -> list[Timing]:
    """Time each call once per round, A B C ... A B C ..., so that disturbances affect all alike.

    Parameters
    ----------
    least_seconds
        time for which a call is repeated within a round; the mean counts. A call that takes longer
        than LONG_SECONDS is timed in LONG_ROUNDS rounds at most, as its fluctuations average out
    warm
        seconds of an earlier call of each; None makes these calls here
    counted
        whether the earlier call was warm: it is the first round, unless rounds repeat the call
    """
    first = [seconds_of(call, 1) for call in calls] if warm is None else list(warm)
    repeats = [max(1, round(least_seconds / max(seconds, 1e-7))) for seconds in first]
    counted = counted or [False] * len(calls)
    samples = [
        [seconds] if is_counted and times == 1 else []
        for is_counted, seconds, times in zip(counted, first, repeats, strict=True)
    ]
    for round_index in range(rounds):
        for k, call in enumerate(calls):
            enough = LONG_ROUNDS if round_index and samples[k][0] > LONG_SECONDS else rounds
            if len(samples[k]) < enough:
                samples[k].append(seconds_of(call, repeats[k]))
    return [_timing(seconds) for seconds in samples]


def seconds_in_turn(
    calls: Sequence[Callable[[], Any]], rounds: int, least_seconds: float
) -> list[list[float]]:
    """Seconds of each warm call in each round, A B C ... A B C ....

    Every second round is backwards, so that calls do not always follow the same one. In a round a
    short call is timed ROUND_PARTS times, repeated for `least_seconds` in all, and the fastest time
    counts, since load only adds. A call that takes more than EVERY_ROUND_SECONDS is made in the
    first LONG_ROUNDS rounds only.
    """
    repeats = [1] * len(calls)
    samples: list[list[float]] = [[] for _ in calls]
    for round_index in range(rounds):
        for k in range(len(calls))[:: -1 if round_index % 2 else 1]:
            if round_index >= LONG_ROUNDS and max(samples[k]) > EVERY_ROUND_SECONDS:
                continue
            if round_index == 0:
                seconds = seconds_of(calls[k])
                repeats[k] = (
                    max(1, round(least_seconds / ROUND_PARTS / seconds)) if seconds > 0.0 else 1
                )
            if round_index or repeats[k] > 1:
                parts = ROUND_PARTS if repeats[k] > 1 else 1
                seconds = min(seconds_of(calls[k], repeats[k]) for _ in range(parts))
            samples[k].append(seconds)
    return samples


def _timing(seconds: Sequence[float]) -> Timing:
    """The timing of the rounds; all NaN where a round is NaN."""
    if any(math.isnan(duration) for duration in seconds):
        return Timing(math.nan, math.nan, math.nan)
    return Timing(statistics.median(seconds), min(seconds), max(seconds))


def seconds_of(call: Callable[[], Any], repeats: int = 1) -> float:
    """The mean seconds of a call over the repeats."""
    if hasattr(call, "seconds"):
        return float(call.seconds(repeats))
    with timed_engines() as spent:
        start = time.perf_counter()
        for _ in range(repeats):
            call()
        wall_seconds = time.perf_counter() - start
    return (spent.seconds or wall_seconds) / repeats


def warmed(call: Callable[[], Any]) -> tuple[Any, float]:
    """The value of a call and its seconds; where these are below LONG_SECONDS, the lesser of them
    and those of a second, warm call."""
    returned, seconds = once(call)
    return returned, min(seconds, seconds_of(call, 1)) if seconds < LONG_SECONDS else seconds


def once(call: Callable[[], Any]) -> tuple[Any, float]:
    """The value of a call and its seconds; NaN where a call in another process failed."""
    with timed_engines() as spent:
        start = time.perf_counter()
        returned = call()
        seconds = spent.seconds or time.perf_counter() - start
    return returned, float(getattr(call, "seconds_of_last_call", seconds))
