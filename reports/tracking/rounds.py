"""Runs of both sides: first calls, runs in further processes, long runs, and samples in the order
A B B A, so that disturbances affect both sides alike."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np

from benchmarks.checks.claim import Report
from benchmarks.statistics.rank_test import samples_needed
from benchmarks.timings.case import LONG, UNTIMED, Case
from benchmarks.work_precision.participants import sampled
from reports.tracking.worker import Failed, Worker

SIDES = ("base", "head")
MIN_ATTEMPT_SECONDS = 0.01  # shortest attempt in seconds
ATTEMPTS = 3  # attempts for a sample, of which the fastest counts
# Seconds of a call above which one attempt suffices: disturbances are shorter:
ONE_ATTEMPT_SECONDS = 0.05
# Smallest number for each side; with 14, two disturbed ones do not hide a slower head:
MIN_SAMPLES = 14
LONG_STEPS = 100_000
LONG_PROBLEM = "driven_oscillator"
LONG_RUNS = 50  # duration of the long run over the ordinary one, for an integrator without a step
LONG_SECONDS = 10.0  # largest estimated time of a long run
LONG_ROUNDING = 1e-3  # error floor of a long run over steps^1.5, as of a phase with random errors
MIN_LENGTHENING = 2  # smallest useful duration of a long run over the ordinary one


@dataclass
class Pair:
    """A benchmark on both sides; the keys of each mapping are sides.

    Attributes
    ----------
    runs
        results of all runs, see the worker's program: `first_calls` of them in the first process,
        then one in each further process
    why
        the reasons of failures
    rounds
        for each round, the samples in seconds
    notes
        sentences on changes to the requested runs
    """

    case: Case
    runs: dict[str, list[dict[str, Any]]] = field(default_factory=lambda: {s: [] for s in SIDES})
    why: dict[str, str] = field(default_factory=dict)
    rounds: list[dict[str, list[float]]] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    @property
    def first_calls(self) -> int:
        """The number of runs in the first process."""
        return 1 if self.case.kind in UNTIMED else 2

    @property
    def reached(self) -> dict[str, dict[str, Any]]:
        """Side -> its first run, for each side that made all of its first calls."""
        return {side: runs[0] for side, runs in self.runs.items() if len(runs) >= self.first_calls}

    @property
    def complete(self) -> bool:
        """Whether both sides made their first calls."""
        return len(self.reached) == len(SIDES)

    @property
    def repeatable(self) -> bool:
        """Whether neither side has failed, and the first process runs the benchmark twice."""
        return not self.why and self.case.kind not in UNTIMED

    @property
    def timed(self) -> bool:
        """Whether there are samples, and neither side has failed."""
        return bool(self.rounds) and not self.why

    def samples(self, round_index: int) -> tuple[list[float], list[float]]:
        """The samples of base and head in one of the rounds."""
        return self.rounds[round_index]["base"], self.rounds[round_index]["head"]

    @property
    def depends_on_process(self) -> bool:
        """Whether a side reached another final state in a further process."""
        return any(self.differs(side, FURTHER_PROCESSES) for side in SIDES)

    def differs(self, side: str, runs: slice) -> bool:
        """Whether the final state of one of these runs differs from that of the first run in any
        bit."""
        first, further = self.runs[side][0]["ends"], self.runs[side][runs]
        return any(not np.array_equal(first, run["ends"], True) for run in further)


SECOND, FURTHER_PROCESSES = slice(1, 2), slice(2, None)  # of the runs of a side


def run_pairs(
    workers: Mapping[str, Worker], pairs: Sequence[Pair], report: Report, further: bool = False
) -> None:
    """Make the first calls of each benchmark on both sides, and append their results to the pairs.

    With `further`, each benchmark is run once more, in other processes than its first calls.
    """
    for pair, side in product(pairs, SIDES):
        report(f"{'in another process' if further else 'first calls'}: {pair.case.name}")
        try:
            for _ in range(1 if further else pair.first_calls):
                pair.runs[side].append(workers[side].run(pair.case))
        except Failed as error:
            pair.why[side] = str(error)


def long_runs(
    workers: Mapping[str, Worker], pairs: Sequence[Pair], limit: float, report: Report
) -> list[Pair]:
    """Make one run of LONG_STEPS steps of each integrator other than galvi; returns their pairs.

    The problem is the driven oscillator, on which late errors of the time show, or else the first
    one that both sides ran. A run is shorter if it would take more than LONG_SECONDS, or than a
    third of the time limit of an answer, and is left out below MIN_LENGTHENING ordinary runs.
    """
    candidates = [pair for pair in pairs if pair.case.contender and pair.repeatable]
    candidates.sort(key=lambda pair: pair.case.problem != LONG_PROBLEM)
    first: dict[str, Pair] = {}
    for pair in candidates:
        first.setdefault(pair.case.contender, pair)
    long = [longer for pair in first.values() if (longer := _lengthened(pair, limit))]
    run_pairs(workers, long, report)
    return long


def _lengthened(pair: Pair, limit: float) -> Pair | None:
    """The pair of the long run that a pair's speed allows; None if it allows none.

    A note on that is added to the pair.
    """
    case = pair.case
    duration, step = case.step * case.steps, case.setting.get("step")
    wanted_times = int(LONG_RUNS if step is None else LONG_STEPS * step / duration)
    seconds = max(reached["warm"] for reached in pair.reached.values())
    times = min(wanted_times, int(min(LONG_SECONDS, limit / 3.0) / max(seconds, 1e-9)))
    if times < MIN_LENGTHENING <= wanted_times:
        sentence = f"No long run was made, because this one already takes {seconds:.2g} s."
        pair.notes += (sentence,)
    if times < MIN_LENGTHENING:
        return None
    setting = sampled(duration * times, case.setting, 1)
    name = f"{case.name}, {times} times as long"
    floor = max(1.0, LONG_ROUNDING * setting.get("save_every", LONG_STEPS) ** 1.5) * case.rounding
    long = replace(case, name=name, kind=LONG, steps=times, setting=setting, rounding=floor)
    shortened = f"Shortened from {wanted_times} times as long, to fit the time limit."
    return Pair(long, notes=(shortened,) if times < wanted_times else ())


def interleave(workers: Mapping[str, Worker], pairs: Sequence[Pair], report: Report) -> None:
    """Add a round of samples to each repeatable pair."""
    repeatable = [pair for pair in pairs if pair.repeatable]
    for pair in repeatable:
        pair.rounds.append({side: [] for side in SIDES})
    count = max(MIN_SAMPLES, samples_needed(len(repeatable)))
    for k in range(count):
        report(f"samples {k + 1} of {count}")
        for pair, side in product(repeatable, SIDES if k % 2 == 0 else SIDES[::-1]):
            if not pair.why:
                _sample(workers[side], pair, side)


def _sample(worker: Worker, pair: Pair, side: str) -> None:
    seconds = max(min(reached["warm"] for reached in pair.reached.values()), 1e-7)
    repeats, attempts = (
        max(1, math.ceil(MIN_ATTEMPT_SECONDS / seconds)),
        1 if seconds > ONE_ATTEMPT_SECONDS else ATTEMPTS,
    )
    try:
        pair.rounds[-1][side].append(worker.time(pair.case, repeats, attempts))
    except Failed as error:
        pair.why[side] = str(error)
