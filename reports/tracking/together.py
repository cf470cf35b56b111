"""The times of all benchmarks of one integrator together: a growth that each alone hides in its
scatter, or that is below the size required of each.

Sample k of a side is the geometric mean over the benchmarks of their k-th times, each over the
median of both sides, so that what disturbs all benchmarks of one moment counts once. Memory layout
slows a whole process by some percent, with equal code: therefore the first round of samples only
raises suspicion, and the mean size that four further rounds of fresh processes show decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.statistics.rank_test import LEVEL, p_value, relative_growth
from reports.tables.number_format import plain
from reports.tracking.gates import TIME
from reports.tracking.rounds import Pair

FEWEST = 3  # benchmarks
SHARE = 0.5  # of the growth required of one benchmark
FURTHER = 4  # rounds after a suspicious one
CONFIRMS = 0.05  # largest p of a further round

Samples = tuple[Sequence[float], Sequence[float]]  # of base and head


@dataclass(frozen=True)
class Together:
    """All timed benchmarks of one integrator.

    Attributes
    ----------
    name
        of the integrator, as "package.module:Class"
    benchmarks
        their names
    rounds
        means of those rounds that all benchmarks have
    size
        relative growth of times that is required
    """

    name: str
    benchmarks: frozenset[str]
    rounds: tuple[Samples, ...]
    size: float

    @property
    def growth(self) -> tuple[float, ...]:
        """Relative growth of times in each round."""
        return tuple(relative_growth(*samples) for samples in self.rounds)

    @property
    def suspicious(self) -> bool:
        """Whether it looks slower in all that was timed so far."""
        return looks_slower(*self.rounds[0], self.size) and _by_rank(self.rounds[1:])

    @property
    def alarms(self) -> dict[str, str]:
        """Its gate and a sentence, where it is slower."""
        further = ", ".join(f"{100 * size:.1f} %" for size in self.growth[1:])
        text = f"{self._slower}, in further rounds by {further}."
        return {TIME: text} if self._is_slower else {}

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence, where it looked slower and is not known to be."""
        if self._is_slower or not looks_slower(*self.rounds[0], self.size):
            return ()
        refuted = len(self.rounds) > FURTHER or not self.suspicious
        why = ", which further rounds did not confirm" if refuted else ""
        return (f"Together {self._slower}{why}.",)

    @property
    def _is_slower(self) -> bool:
        return looks_slower(*self.rounds[0], self.size) and is_slower(self.rounds[1:], self.size)

    @property
    def _slower(self) -> str:
        p = plain(p_value(*self.rounds[0]), 2)
        count, size = len(self.benchmarks), 100 * self.growth[0]
        return f"its {count} timed benchmarks are slower by {size:.1f} % (p = {p})"


def judge_together(pairs: Iterable[Pair]) -> tuple[Together, ...]:
    """The times of each integrator of a project, where it has enough benchmarks."""
    timed: dict[str, list[Pair]] = {}
    for pair in pairs:
        if pair.case.contender and pair.timed:
            timed.setdefault(pair.case.contender, []).append(pair)
    return tuple(
        Together(
            name,
            frozenset(pair.case.name for pair in group),
            tuple(
                means([pair.samples(at) for pair in group])
                for at in range(min(len(pair.rounds) for pair in group))
            ),
            SHARE * max(pair.case.slower for pair in group),
        )
        for name, group in timed.items()
        if len(group) >= FEWEST
    )


def suspected(pairs: Iterable[Pair], red: set[str]) -> set[str]:
    """Names of the benchmarks of integrators that look slower in all that was timed so far.

    Parameters
    ----------
    red
        names of benchmarks that are slower by their own times: their integrators need no more
    """
    doubtful = [group for group in judge_together(pairs) if group.suspicious]
    return {name for group in doubtful if not red & group.benchmarks for name in group.benchmarks}


def looks_slower(base: Sequence[float], head: Sequence[float], size: float) -> bool:
    """Whether a first round is suspicious: by rank and by size."""
    return relative_growth(base, head) > size and p_value(base, head) < LEVEL


def is_slower(further: Sequence[Samples], size: float) -> bool:
    """Whether rounds after a suspicious one confirm it: each by rank, their mean by size."""
    growth = [relative_growth(*samples) for samples in further]
    return len(further) >= FURTHER and _by_rank(further) and float(np.mean(growth)) > size


def _by_rank(further: Sequence[Samples]) -> bool:
    return all(p_value(*samples) < CONFIRMS for samples in further)


def means(samples: Sequence[Samples]) -> Samples:
    """The samples of base and head, each the geometric mean of those of the benchmarks.

    Parameters
    ----------
    samples
        of base and head, for each benchmark; of equal numbers
    """
    times = np.array(samples, dtype=float)
    middle = np.median(times, axis=(1, 2), keepdims=True)
    base, head = np.exp(np.mean(np.log(times / middle), axis=0))
    return base.tolist(), head.tolist()
