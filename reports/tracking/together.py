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

from benchmarks.statistics.rank_test import SIGNIFICANCE, p_value, relative_growth
from reports.tables.number_format import plain
from reports.tracking.gates import TIME, suspects
from reports.tracking.rounds import Pair

MIN_BENCHMARKS = 3  # benchmarks
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
    def looked_slower(self) -> bool:
        """Whether the first round is suspicious: by rank and by size."""
        return self.growth[0] > self.size and p_value(*self.rounds[0]) < SIGNIFICANCE

    @property
    def suspicious(self) -> bool:
        """Whether it looks slower in all that was timed so far: in further rounds by rank."""
        confirmed = (p_value(*samples) < CONFIRMS for samples in self.rounds[1:])
        return self.looked_slower and all(confirmed)

    @property
    def alarms(self) -> dict[str, str]:
        """Its gate and a sentence, where enough further rounds confirm it, their mean by size."""
        further = self.growth[1:]
        if not (self.suspicious and len(further) >= FURTHER and np.mean(further) > self.size):
            return {}
        sizes = ", ".join(f"{100 * size:.1f} %" for size in further)
        return {TIME: f"{self._sentence('are')}; in further rounds {sizes}."}

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence, where it looked slower and is not known to be."""
        if self.alarms or not self.looked_slower:
            return ()
        if self.suspicious and len(self.rounds) <= FURTHER:
            return (f"{self._sentence('are')}.",)
        return (f"{self._sentence('looked')}; further rounds did not confirm it.",)

    def _sentence(self, verb: str) -> str:
        growth, p = 100 * self.growth[0], plain(p_value(*self.rounds[0]), 2)
        benchmarks = f"Its {len(self.benchmarks)} timed benchmarks together"
        return f"{benchmarks} {verb} {growth:.1f} % slower (p = {p})"


def judge_together(pairs: Iterable[Pair]) -> tuple[Together, ...]:
    """The times of each integrator of a project, where it has enough benchmarks."""
    groups: dict[str, list[Pair]] = {}
    for pair in pairs:
        if pair.case.contender and pair.timed:
            groups.setdefault(pair.case.contender, []).append(pair)
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
        for name, group in groups.items()
        if len(group) >= MIN_BENCHMARKS
    )


def suspected(pairs: Sequence[Pair]) -> set[str]:
    """Names of the benchmarks of integrators that look slower in all that was timed so far, except
    where one of them is slower by its own times already."""
    slower = suspects(pairs, 0) & suspects(pairs, 1)
    groups = [group.benchmarks for group in judge_together(pairs) if group.suspicious]
    return set().union(*(group for group in groups if not slower & group))


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
