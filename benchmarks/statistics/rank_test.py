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

SIGNIFICANCE = 0.002  # probability of any false alarm by rank alone
FEWEST_SAMPLES = 7  # per side
SIGNIFICANCE_MARGIN = (
    10.0  # least ratio of the level of Holm's first step to the smallest possible p
)
POWER, DRAWS = 0.9, 40  # a visible growth is detected in this fraction of the draws
GROWTHS = np.concatenate(
    [np.arange(0.01, 0.3, 0.01), np.arange(0.3, 1.0, 0.05), np.arange(1.0, 3.1, 0.25)]
).round(2)


def p_value(base: Sequence[float], head: Sequence[float]) -> float:
    """The probability that samples of equal code rank the head at least as slow.

    It is exact, and an upper bound where times are equal, as with a coarse clock: such a pair
    counts as one in which the head is faster. 1.0 for fewer than FEWEST_SAMPLES samples per side.

    Raises
    ------
    ValueError
        For a time that is not finite and positive.
    """
    for name, times in (("base", base), ("head", head)):
        invalid = [time for time in times if not (math.isfinite(time) and time > 0.0)]
        if invalid:
            raise ValueError(
                f"times of the {name} must be positive and finite; received {invalid[0]!r}. "
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


def holm(p_values: Mapping[str, float], level: float = SIGNIFICANCE) -> set[str]:
    """The names that remain significant after Holm's correction."""
    significant: set[str] = set()
    for name in sorted(p_values, key=p_values.__getitem__):
        if p_values[name] >= level / (len(p_values) - len(significant)):
            break
        significant.add(name)
    return significant


def samples_needed(benchmarks: int, level: float = SIGNIFICANCE) -> int:
    """Samples per side with which complete separation passes Holm's first step by the factor
    SIGNIFICANCE_MARGIN; at least FEWEST_SAMPLES."""
    count = FEWEST_SAMPLES
    while 1.0 / math.comb(2 * count, count) >= level / (max(1, benchmarks) * SIGNIFICANCE_MARGIN):
        count += 1
    return count


def smallest_visible(
    base: Sequence[float], head: Sequence[float], benchmarks: int, size: float, seed: int = 0
) -> float:
    """The least relative growth that is detected in POWER of the draws; infinite beyond 300 %.

    Parameters
    ----------
    base, head
        samples, each side relative to its median, so that their code may differ
    benchmarks
        number of benchmarks that are compared together: Holm's first step divides the level by it
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
        is_large = (1.0 + growth) * ratios - 1.0 > size
        if (
            np.mean(
                is_large & (_p_values(equal, (1.0 + growth) * slower) < SIGNIFICANCE / benchmarks)
            )
            >= POWER
        ):
            return float(growth)
    return math.inf


def slower(
    samples: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    sizes: Mapping[str, float],
    level: float = SIGNIFICANCE,
) -> set[str]:
    """Names of the benchmarks whose head is slower by rank and by size.

    Parameters
    ----------
    samples
        name -> times of base and head
    sizes
        name -> relative growth of the median that must be exceeded
    """
    by_rank = holm({name: p_value(*pair) for name, pair in samples.items()}, level)
    return {name for name in by_rank if relative_growth(*samples[name]) > sizes[name]}
