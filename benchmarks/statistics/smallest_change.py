"""The smallest growth of time that a comparison sees, from recorded samples of equal code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.statistics.rank_test import LEVEL, p_value, relative_growth

POWER = 0.9  # share of the draws in which the growth is seen
DRAWS = 40
GROWTHS = tuple(
    np.round(np.concatenate([np.arange(0.01, 0.3, 0.01), np.arange(0.3, 1.01, 0.05)]), 2)
)


def smallest_change(
    base: Sequence[float],
    head: Sequence[float],
    size: float,
    benchmarks: int = 1,
    seed: int = 0,
) -> float:
    """The least relative growth that is seen in POWER of the draws; inf beyond 100 %.

    base, head  samples taken in the order A B B A, of equal code or scaled to equal medians here
    size        growth of the median required besides the rank test
    benchmarks  number compared at a time, by which Holm's first step divides the level

    Each draw takes both sides with replacement from the samples divided by their side's median.
    """
    both = np.concatenate([np.asarray(side) / np.median(side) for side in (base, head)])
    random = np.random.Generator(np.random.Philox(seed))
    count = min(len(base), len(head))
    draws = [random.choice(both, (2, count)) for _ in range(DRAWS)]

    def seen(growth: float) -> float:
        hits = 0
        for one, other in draws:
            slow = (1.0 + growth) * other
            hits += relative_growth(one, slow) > size and p_value(one, slow) < LEVEL / benchmarks
        return hits / DRAWS

    low, high = 0, len(GROWTHS)  # the share rises with the growth
    while low < high:
        middle = (low + high) // 2
        if seen(float(GROWTHS[middle])) >= POWER:
            high = middle
        else:
            low = middle + 1
    return float(GROWTHS[low]) if low < len(GROWTHS) else float("inf")
