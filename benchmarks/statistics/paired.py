"""Ratios of times taken in the same rounds: a median with an interval, and what is a tie."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

COVERAGE = 0.95  # least, of an interval
FASTER, SLOWER, TIE = "galvi faster", "galvi slower", "tie"
UNRESOLVED = "within noise"  # how a tie is called whose own interval does not hold 1


class Interval(NamedTuple):
    """A median with bounds that hold its true value in COVERAGE of cases; NaN where unknown."""

    low: float
    median: float
    high: float


UNKNOWN = Interval(math.nan, math.nan, math.nan)


def interval(values: Sequence[float]) -> Interval:
    """Of values drawn independently from any distribution: those of the ranks k and n + 1 - k,
    with the largest k that covers the median in COVERAGE of cases (e.g. David and Nagaraja, Order
    Statistics, 7.1). Without such a k, for fewer than six values, the bounds are NaN."""
    if not values:
        return UNKNOWN
    ordered = sorted(values)
    n, rank = len(ordered), _rank(len(ordered))
    middle = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    if rank == 0:
        return Interval(math.nan, middle, math.nan)
    return Interval(ordered[rank - 1], middle, ordered[n - rank])


@cache
def _rank(n: int) -> int:
    """The largest k with 2 P(fewer than k of n below the median) <= 1 - COVERAGE; 0 for none."""
    rank, below = 0, 0.0
    for k in range(n // 2):
        below += math.comb(n, k) * 0.5**n
        if 2.0 * below > 1.0 - COVERAGE:
            break
        rank = k + 1
    return rank


def ratio(rival_seconds: Sequence[float], own_seconds: Sequence[float]) -> Interval:
    """Of the times of two calls, in seconds, round by round: what disturbs a round disturbs both.

    Raises
    ------
    ValueError
        For different numbers of rounds.
    """
    return interval([a / b for a, b in zip(rival_seconds, own_seconds, strict=True)])


def outcome(speed_ratio: Interval, noise: Interval) -> str:
    """What a ratio of a rival's time to one's own says: FASTER or SLOWER, where its interval and
    that of the same call against itself, `noise`, leave out each other; else TIE, and '' where
    either is unknown. Either may have missed 1 by chance: both are widened to hold it."""
    bounds = (speed_ratio.low, speed_ratio.high, noise.low, noise.high)
    if any(math.isnan(bound) for bound in bounds):
        return ""
    if speed_ratio.low > max(1.0, noise.high):
        return FASTER
    return SLOWER if speed_ratio.high < min(1.0, noise.low) else TIE


def written(seconds: Sequence[float]) -> str:
    """The rounds as a text, for a table."""
    return " ".join(f"{duration:.6g}" for duration in seconds)


def read(text: object) -> list[float]:
    """The rounds of such a text; none of an empty or a missing one."""
    return [float(word) for word in text.split()] if isinstance(text, str) else []
