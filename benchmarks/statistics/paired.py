"""Ratios of times taken in the same rounds: a median with an interval, and a verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

COVERAGE = 0.95  # least probability that an interval contains the true median
FASTER, SLOWER, TIE = "galvi faster", "galvi slower", "tie"
UNRESOLVED = "within noise"  # a tie whose own interval does not contain 1


class Interval(NamedTuple):
    """A median with bounds that contain its true value with probability COVERAGE; NaN where
    unknown."""

    low: float
    median: float
    high: float


UNKNOWN = Interval(math.nan, math.nan, math.nan)


def interval(values: Sequence[float]) -> Interval:
    """The median of values drawn independently from any distribution, with bounds.

    The bounds are the values of ranks k and n + 1 - k, with the largest k for which they contain
    the true median with probability COVERAGE (e.g. David and Nagaraja, Order Statistics, 7.1). For
    fewer than six values there is no such k, and the bounds are NaN; without values, all are.
    """
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
    """The median ratio of the times of two calls, taken round by round, as disturbances affect
    both.

    Raises
    ------
    ValueError
        For different numbers of rounds.
    """
    return interval([a / b for a, b in zip(rival_seconds, own_seconds, strict=True)])


def outcome(speed_ratio: Interval, noise: Interval) -> str:
    """FASTER, SLOWER or TIE; '' where a bound is NaN.

    FASTER and SLOWER: the interval of the ratio of a rival's time to galvi's lies above or below
    `noise`, the interval of galvi's call against itself. Both are first widened to contain 1, which
    either may miss by chance.
    """
    bounds = (speed_ratio.low, speed_ratio.high, noise.low, noise.high)
    if any(math.isnan(bound) for bound in bounds):
        return ""
    if speed_ratio.low > max(1.0, noise.high):
        return FASTER
    return SLOWER if speed_ratio.high < min(1.0, noise.low) else TIE


def written(seconds: Sequence[float]) -> str:
    """The seconds of the rounds as text, for a table."""
    return " ".join(f"{duration:.6g}" for duration in seconds)


def read(text: object) -> list[float]:
    """The seconds in a text of `written`; [] for an empty or a missing text."""
    return [float(word) for word in text.split()] if isinstance(text, str) else []
