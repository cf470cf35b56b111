"""The times of all benchmarks of one integrator together, which show a growth that is hidden in the
scatter of each benchmark, or is below the size required of each.

Sample k of a side is the geometric mean, over the benchmarks, of their k-th times relative to the
median of both sides, so that a disturbance of all benchmarks at one moment counts once. Memory
layout alone slows a whole process by some percent: therefore the first round of samples only raises
a suspicion, and the mean growth in FURTHER_ROUNDS rounds of fresh processes decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.statistics.rank_test import SIGNIFICANCE, p_value, relative_growth
from reports.tables.number_format import plain
from reports.tracking.gates import TIME, suspects
from reports.tracking.rounds import Pair

MIN_BENCHMARKS = 3  # smallest number of benchmarks that are taken together
REQUIRED_FRACTION = 0.5  # required growth over that which is required of one benchmark
FURTHER_ROUNDS = 4  # rounds after a suspicious one
MAX_CONFIRMING_P = 0.05  # largest p of a further round that confirms the suspicion

Samples = tuple[Sequence[float], Sequence[float]]  # of base and head


@dataclass(frozen=True)
class Together:
    """All timed benchmarks of one integrator.

    Attributes
    ----------
    name
        name of the integrator, as "package.module:Class"
    benchmarks
        names of the benchmarks
    rounds
        means of the rounds that all benchmarks have
    size
        relative growth of times that is required for an alarm
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
        """Whether the head is slower in the first round, by rank and by size."""
        return self.growth[0] > self.size and p_value(*self.rounds[0]) < SIGNIFICANCE

    @property
    def suspicious(self) -> bool:
        """Whether the head looks slower in all rounds so far; for further ones only by rank."""
        confirmed = (p_value(*samples) < MAX_CONFIRMING_P for samples in self.rounds[1:])
        return self.looked_slower and all(confirmed)

    @property
    def alarms(self) -> dict[str, str]:
        """TIME -> a sentence, if FURTHER_ROUNDS further rounds confirm the suspicion and their mean
        growth exceeds `size`; else {}."""
        further = self.growth[1:]
        if not (
            self.suspicious and len(further) >= FURTHER_ROUNDS and np.mean(further) > self.size
        ):
            return {}
        sizes = ", ".join(f"{100 * size:.1f} %" for size in further)
        return {TIME: f"{self._sentence('are')}; in further rounds {sizes}."}

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence, if the first round looked slower, but there is no alarm; else ()."""
        if self.alarms or not self.looked_slower:
            return ()
        if self.suspicious and len(self.rounds) <= FURTHER_ROUNDS:
            return (f"{self._sentence('are')}.",)
        return (f"{self._sentence('looked')}; further rounds did not confirm it.",)

    def _sentence(self, verb: str) -> str:
        growth, p = 100 * self.growth[0], plain(p_value(*self.rounds[0]), 2)
        benchmarks = f"Its {len(self.benchmarks)} timed benchmarks together"
        return f"{benchmarks} {verb} {growth:.1f} % slower (p = {p})"


def growths_together(pairs: Iterable[Pair]) -> tuple[Together, ...]:
    """The times together of each integrator of a project that has MIN_BENCHMARKS timed ones."""
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
            REQUIRED_FRACTION * max(pair.case.slower for pair in group),
        )
        for name, group in groups.items()
        if len(group) >= MIN_BENCHMARKS
    )


def suspected(pairs: Sequence[Pair]) -> set[str]:
    """Names of the benchmarks of integrators that look slower in all rounds so far.

    Integrators one of whose benchmarks is slower by its own times are left out.
    """
    slower = suspects(pairs, 0) & suspects(pairs, 1)
    groups = [group.benchmarks for group in growths_together(pairs) if group.suspicious]
    return set().union(*(group for group in groups if not slower & group))


def means(samples: Sequence[Samples]) -> Samples:
    """The samples of base and head as geometric means over the benchmarks.

    Parameters
    ----------
    samples
        for each benchmark its samples of base and head, all of the same number
    """
    times = np.array(samples, dtype=float)
    medians = np.median(times, axis=(1, 2), keepdims=True)
    base, head = np.exp(np.mean(np.log(times / medians), axis=0))
    return base.tolist(), head.tolist()
