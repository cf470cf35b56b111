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
FEWEST_SAMPLES = 7  # per side
SPARE = 10.0  # margin of the least possible p below the level of Holm's first step
POWER, DRAWS = 0.9, 40  # share of the draws in which a visible growth counts
GROWTHS = np.concatenate(
    [np.arange(0.01, 0.3, 0.01), np.arange(0.3, 1.0, 0.05), np.arange(1.0, 3.1, 0.25)]
).round(2)


def p_value(base: Sequence[float], head: Sequence[float]) -> float:
    """The probability that equal code gives a head that looks at least as slow: exact, and an upper
    bound where times are equal, as a coarse clock gives them, since each such pair counts as one
    in which the head is faster.

    1.0 for fewer than FEWEST_SAMPLES samples per side.

    Raises
    ------
    ValueError
        For a time that is not finite and positive.
    """
    for name, times in (("base", base), ("head", head)):
        wrong = [time for time in times if not (math.isfinite(time) and time > 0.0)]
        if wrong:
            raise ValueError(
                f"times of the {name} must be positive and finite; received {wrong[0]!r}. "
                "Leave out a sample that failed."
            )
    return float(_p_values(base, head)) if min(len(base), len(head)) >= FEWEST_SAMPLES else 1.0


def _p_values(base: np.ndarray | Sequence[float], head: np.ndarray | Sequence[float]) -> np.ndarray:
    """The p-values of samples along the last axis."""
    from scipy.stats import mannwhitneyu  # a sixth of the import of a report

    # the exact distribution holds for ranks without ties; a stable sort puts the head's times first
    times = np.concatenate([head, base], axis=-1)
    ranks = np.argsort(np.argsort(times, axis=-1, kind="stable"), axis=-1)
    head_ranks, base_ranks = np.split(ranks, [np.shape(head)[-1]], axis=-1)
    return mannwhitneyu(
        head_ranks, base_ranks, alternative="greater", method="exact", axis=-1
    ).pvalue


def relative_growth(base: Sequence[float], head: Sequence[float]) -> float:
    """Median of the head over median of the base, less 1."""
    return statistics.median(head) / statistics.median(base) - 1.0


def holm(p_values: Mapping[str, float], level: float = LEVEL) -> set[str]:
    """The names that remain significant after Holm's correction."""
    significant: set[str] = set()
    for name in sorted(p_values, key=p_values.__getitem__):
        if p_values[name] >= level / (len(p_values) - len(significant)):
            break
        significant.add(name)
    return significant


def samples_needed(benchmarks: int, level: float = LEVEL) -> int:
    """Samples per side with which complete separation passes Holm's first step by SPARE."""
    count = FEWEST_SAMPLES
    while 1.0 / math.comb(2 * count, count) >= level / (max(1, benchmarks) * SPARE):
        count += 1
    return count


def smallest_visible(
    base: Sequence[float], head: Sequence[float], benchmarks: int, size: float, seed: int = 0
) -> float:
    """The least relative growth that counts in POWER of the draws; infinite beyond 300 %.

    Parameters
    ----------
    base, head
        samples of equal code; of other code, each side is scaled to its median
    benchmarks
        number compared at a time, by which Holm's first step divides the level
    size
        growth of the median required besides the rank test

    Notes
    -----
    Each draw takes both sides with replacement from all samples.
    """
    times = np.concatenate([np.asarray(side) / np.median(side) for side in (base, head)])
    random = np.random.Generator(np.random.Philox(seed))
    equal, slower = random.choice(times, (2, DRAWS, min(len(base), len(head))))
    ratios = np.median(slower, axis=1) / np.median(equal, axis=1)
    for growth in GROWTHS:
        large = (1.0 + growth) * ratios - 1.0 > size
        if (
            np.mean(large & (_p_values(equal, (1.0 + growth) * slower) < LEVEL / benchmarks))
            >= POWER
        ):
            return float(growth)
    return math.inf


def slower(
    samples: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    sizes: Mapping[str, float],
    level: float = LEVEL,
) -> set[str]:
    """Names of the benchmarks whose head is slower by rank and by size.

    Parameters
    ----------
    samples
        name -> times of base and head
    sizes
        name -> relative growth of the median that is also required
    """
    by_rank = holm({name: p_value(*pair) for name, pair in samples.items()}, level)
    return {name for name in by_rank if relative_growth(*samples[name]) > sizes[name]}
