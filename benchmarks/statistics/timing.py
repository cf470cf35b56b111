"""Times of several calls that compare: interleaved rounds, warmed up, with an interval.

A call that runs in another process has its own clock there: ``seconds(repeats)``, the mean of so
many calls, and ``took``, the seconds of the last one.
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


def call_of(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Callable[[], Trajectory]:
    """A call that runs the contender: its own ``timed``, when it measures its times itself."""
    timed = getattr(contender, "timed", None)
    if timed is not None:
        call: Callable[[], Trajectory] = timed(problem, duration, setting)
        return call
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
    least: float,
    warm: Sequence[float] | None = None,
) -> list[Timing]:
    """Time each call once a round, A B C ... A B C ..., so that a slow moment hits all alike.

    least  seconds that a call is repeated for within a round; its mean counts
    warm   seconds of an earlier call of each, which has compiled and loaded what it needs; None
           makes that call here
    """
    first = [_seconds(call, 1) for call in calls] if warm is None else list(warm)
    repeats = [max(1, round(least / max(seconds, 1e-7))) for seconds in first]
    samples: list[list[float]] = [[] for _ in calls]
    for _ in range(rounds):
        for k, call in enumerate(calls):
            samples[k].append(_seconds(call, repeats[k]))
    return [_timing(seconds) for seconds in samples]


def _timing(seconds: Sequence[float]) -> Timing:
    """Nothing but NaN when a round had no time."""
    if any(math.isnan(one) for one in seconds):
        return Timing(math.nan, math.nan, math.nan)
    return Timing(statistics.median(seconds), min(seconds), max(seconds))


def _seconds(call: Callable[[], Any], repeats: int) -> float:
    if hasattr(call, "seconds"):
        return float(call.seconds(repeats))
    start = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - start) / repeats


def warmed(call: Callable[[], Any]) -> tuple[Any, float]:
    """The result of a call, and its seconds when everything it needs is compiled and loaded."""
    result, seconds = once(call)
    return result, min(seconds, _seconds(call, 1)) if seconds < 1.0 else seconds


def once(call: Callable[[], Any]) -> tuple[Any, float]:
    """The result of a call, and its seconds; NaN where its own clock failed."""
    start = time.perf_counter()
    result = call()
    seconds = time.perf_counter() - start
    return result, float(getattr(call, "took", seconds))
