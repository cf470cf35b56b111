"""Decide whether times got worse: a rank test and a threshold, corrected for multiple benchmarks.

The Mann-Whitney test (Ann. Math. Stat. 18 (1947) 50) asks whether samples of one side tend to be
larger, for any distribution; Holm's correction (Scand. J. Stat. 6 (1979) 65) keeps the probability
of any false alarm among all benchmarks below the level.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence

import numpy as np

LEVEL = 0.002  # probability of any false alarm by rank alone
LEAST = 7  # fewest samples per side
SPARE = 10.0  # margin of the least possible p below the level of Holm's first step


def p_value(base: Sequence[float], head: Sequence[float]) -> float:
    """The probability that equal code gives a head that looks at least as slow.

    1.0 for fewer than LEAST samples per side. Raises ValueError for a time that is not finite and
    positive.
    """
    for name, times in (("base", base), ("head", head)):
        wrong = [time for time in times if not (math.isfinite(time) and time > 0.0)]
        if wrong:
            raise ValueError(
                f"times of the {name} must be positive and finite; received {wrong[0]!r}. "
                "Leave out a sample that failed."
            )
    if min(len(base), len(head)) < LEAST:
        return 1.0
    from scipy.stats import rankdata  # a sixth of the import of a report

    doubled = [round(2 * rank) for rank in rankdata([*head, *base])]
    return _at_least(sum(doubled[: len(head)]), doubled, len(head))


def _at_least(reached: int, ranks: Sequence[int], count: int) -> float:
    """The share of choices of `count` ranks whose sum is at least `reached`; exact with ties,
    where a normal approximation for few samples is never significant after Holm's correction.
    """
    ways = np.zeros((count + 1, sum(ranks) + 1))  # choices, by how many are chosen and their sum
    ways[0, 0] = 1.0
    for rank in ranks:
        ways[1:, rank:] += ways[:-1, :-rank]
    return float(np.sum(ways[count, reached:]) / math.comb(len(ranks), count))


def relative_growth(base: Sequence[float], head: Sequence[float]) -> float:
    """Median of the head over median of the base, less 1."""
    return statistics.median(head) / statistics.median(base) - 1.0


def holm(chances: Mapping[str, float], level: float = LEVEL) -> set[str]:
    """The names that remain significant after Holm's correction."""
    kept = set()
    ranked = sorted(chances.items(), key=lambda item: item[1])
    for k, (name, one) in enumerate(ranked):
        if one >= level / (len(ranked) - k):
            break
        kept.add(name)
    return kept


def samples_needed(benchmarks: int, level: float = LEVEL) -> int:
    """Samples per side with which complete separation passes Holm's first step by SPARE."""
    count = LEAST
    while 1.0 / math.comb(2 * count, count) >= level / (max(1, benchmarks) * SPARE):
        count += 1
    return count


def smallest_visible(
    base: Sequence[float], benchmarks: int, size: float, level: float = LEVEL
) -> float:
    """The least relative growth of all times that would count beside this scatter of the base.

    benchmarks  how many are compared
    size        growth of the median that is also required

    To a hundredth; infinite where a growth by 300 % would not be seen.
    """

    def seen(growth: float) -> bool:
        head = [(1.0 + growth) * time for time in base]
        return p_value(base, head) < level / max(1, benchmarks)

    low, high = size, 3.0
    if not seen(high):
        return math.inf
    if seen(low):
        return low
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if seen(middle) else (middle, high)
    return high


def slower(
    samples: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    sizes: Mapping[str, float],
    level: float = LEVEL,
) -> set[str]:
    """Names of the benchmarks whose head is slower by rank and by size.

    samples  name -> times of base and head
    sizes    name -> relative growth of the median that is also required
    """
    ranks = holm({name: p_value(*pair) for name, pair in samples.items()}, level)
    return {name for name in ranks if relative_growth(*samples[name]) > sizes[name]}
