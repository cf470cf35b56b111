"""Whether times got worse: a rank test and a size, corrected for the number of benchmarks.

Numbers only. Mann and Whitney's test (Ann. Math. Stat. 18 (1947) 50) asks whether samples of one
side tend to be larger, whatever their distribution; Holm's correction (Scand. J. Stat. 6 (1979) 65)
keeps the chance of any false alarm among all benchmarks below the level.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence

from scipy.stats import rankdata

LEVEL = 0.002  # chance of any false alarm by rank alone
LEAST = 7  # samples a side
SPARE = 10.0  # by how much the least p that so many samples can give stays below what Holm asks


def p_value(base: Sequence[float], head: Sequence[float]) -> float:
    """The chance that equal code gives a head that looks at least as slow.

    1.0 for fewer than LEAST samples a side, since they decide nothing. Raises ValueError for a
    time that is not finite or not positive.
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
    doubled = [round(2 * rank) for rank in rankdata([*head, *base])]
    return _at_least(sum(doubled[: len(head)]), doubled, len(head))


def _at_least(reached: int, ranks: Sequence[int], count: int) -> float:
    """The share of the choices of so many of these ranks whose sum reaches that; exact with ties,
    where a normal approximation of few samples never gets below what Holm asks.
    """
    ways: list[dict[int, int]] = [{0: 1}] + [{} for _ in range(count)]  # sum: choices, by number
    for rank in ranks:
        for chosen in range(count, 0, -1):
            for total, many in ways[chosen - 1].items():
                ways[chosen][total + rank] = ways[chosen].get(total + rank, 0) + many
    reaching = sum(many for total, many in ways[count].items() if total >= reached)
    return reaching / math.comb(len(ranks), count)


def relative_growth(base: Sequence[float], head: Sequence[float]) -> float:
    """Median of the head over median of the base, less 1."""
    return statistics.median(head) / statistics.median(base) - 1.0


def holm(chances: Mapping[str, float], level: float = LEVEL) -> set[str]:
    """The names that stay significant when all of them are looked at together."""
    kept = set()
    ranked = sorted(chances.items(), key=lambda item: item[1])
    for k, (name, one) in enumerate(ranked):
        if one >= level / (len(ranked) - k):
            break
        kept.add(name)
    return kept


def samples_needed(benchmarks: int, level: float = LEVEL) -> int:
    """Samples a side with which complete separation passes Holm's first step, and SPARE besides."""
    count = LEAST
    while 1.0 / math.comb(2 * count, count) >= level / (max(1, benchmarks) * SPARE):
        count += 1
    return count


def slower(
    samples: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    sizes: Mapping[str, float],
    level: float = LEVEL,
) -> set[str]:
    """Benchmarks whose head is slower by rank and by size.

    samples  of base and head
    sizes    relative growth of the median that is needed besides
    """
    ranks = holm({name: p_value(*pair) for name, pair in samples.items()}, level)
    return {name for name in ranks if relative_growth(*samples[name]) > sizes[name]}
