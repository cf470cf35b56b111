"""The times of all benchmarks of one integrator together: a growth that each alone hides in its
scatter, or that is below the size required of each.

Sample k of a side is the geometric mean over the benchmarks of their k-th times, each over the
median of both sides, so that what disturbs all benchmarks of one moment counts once. Memory layout
slows a whole process by some percent, with equal code: therefore the first round of samples only
raises suspicion, and the mean size that four further rounds of fresh processes show decides.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.statistics.rank_test import LEVEL, p_value, relative_growth
from reports.tables.number_format import plain
from reports.tracking.rounds import SIDES, Pair

FEWEST = 3  # benchmarks
SHARE = 0.5  # of the growth required of one benchmark
FURTHER = 4  # rounds after a suspicious one
CONFIRMS = 0.05  # largest p of a further round


@dataclass(frozen=True)
class Together:
    """All timed benchmarks of one integrator.

    name     of the integrator, as "package.module:Class"
    growth   relative growth of times in each round that was made
    alarm    a sentence, "" where it is not slower
    note     a sentence, "" where it did not look slower
    """

    name: str
    growth: tuple[float, ...]
    alarm: str
    note: str


def groups(pairs: Iterable[Pair]) -> dict[str, list[Pair]]:
    """The timed benchmarks of each integrator of a project, where there are enough."""
    timed: dict[str, list[Pair]] = {}
    for pair in pairs:
        if pair.case.contender and pair.rounds and not pair.why:
            timed.setdefault(pair.case.contender, []).append(pair)
    return {name: group for name, group in timed.items() if len(group) >= FEWEST}


Samples = tuple[Sequence[float], Sequence[float]]  # of base and head


def means(samples: Sequence[Samples]) -> Samples:
    """The samples of base and head, each the geometric mean of those of the benchmarks.

    samples  of base and head, for each benchmark; of equal numbers
    """
    times = np.array(samples, dtype=float)
    middle = np.median(times, axis=(1, 2), keepdims=True)
    base, head = np.exp(np.mean(np.log(times / middle), axis=0))
    return base.tolist(), head.tolist()


def looks_slower(base: Sequence[float], head: Sequence[float], size: float) -> bool:
    """Whether a first round is suspicious: by rank and by size."""
    return relative_growth(base, head) > size and p_value(base, head) < LEVEL


def is_slower(further: Sequence[Samples], size: float) -> bool:
    """Whether rounds after a suspicious one confirm it: each by rank, their mean by size."""
    growth = [relative_growth(*both) for both in further]
    return len(further) >= FURTHER and _by_rank(further) and float(np.mean(growth)) > size


def _by_rank(further: Sequence[Samples]) -> bool:
    return all(p_value(*both) < CONFIRMS for both in further)


def suspected(pairs: Iterable[Pair], red: Collection[str]) -> set[str]:
    """Names of the benchmarks of integrators that look slower in all that was timed so far.

    red  names of benchmarks that are slower by their own times: their integrators need no more
    """
    return {
        pair.case.name
        for group in groups(pairs).values()
        if _suspicious(group) and _by_rank(_rounds(group)[1:])
        if not any(pair.case.name in red for pair in group)
        for pair in group
    }


def judge_together(pairs: Iterable[Pair]) -> tuple[Together, ...]:
    """What the times of each integrator come to."""
    return tuple(_judged(name, group) for name, group in groups(pairs).items())


def _judged(name: str, group: Sequence[Pair]) -> Together:
    rounds = _rounds(group)
    growth = tuple(relative_growth(*both) for both in rounds)
    first, *later = (f"{100 * size:.1f} %" for size in growth)
    text = (
        f"its {len(group)} timed benchmarks are slower by {first} "
        f"(p = {plain(p_value(*rounds[0]), 2)})"
    )
    if not _suspicious(group):
        return Together(name, growth, "", "")
    if is_slower(rounds[1:], _size(group)):
        return Together(name, growth, f"{text}, in further rounds by {', '.join(later)}.", "")
    asked = len(later) >= FURTHER or not _by_rank(rounds[1:])
    why = ", which further rounds did not confirm" if asked else ""
    return Together(name, growth, "", f"Together {text}{why}.")


def _suspicious(group: Sequence[Pair]) -> bool:
    return looks_slower(*_rounds(group)[0], _size(group))


def _size(group: Sequence[Pair]) -> float:
    return SHARE * max(pair.case.slower for pair in group)


def _rounds(group: Sequence[Pair]) -> list[Samples]:
    """The means of those rounds that all benchmarks have."""
    shared = min(len(pair.rounds) for pair in group)
    return [
        means([tuple(pair.rounds[at][side] for side in SIDES) for pair in group])  # type: ignore[misc]
        for at in range(shared)
    ]
