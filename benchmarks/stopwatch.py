"""Times that may be compared: interleaved rounds, warmed up, with an interval."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


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
    return [Timing(statistics.median(s), min(s), max(s)) for s in samples]


def _seconds(call: Callable[[], Any], repeats: int) -> float:
    start = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - start) / repeats


def warmed(call: Callable[[], Any]) -> tuple[Any, float]:
    """What the call returns, and the seconds it takes when what it needs is compiled and loaded."""
    start = time.perf_counter()
    result = call()
    seconds = time.perf_counter() - start
    return result, min(seconds, _seconds(call, 1)) if seconds < 1.0 else seconds
