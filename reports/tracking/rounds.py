"""Runs of two sides: first calls, runs in further processes, long runs, and interleaved samples,
A B B A, so that disturbances affect both alike."""

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
SHORTEST_ATTEMPT = 0.01  # shortest attempt in seconds
ATTEMPTS = 3  # per sample, of which the fastest counts
ONE_ATTEMPT = 0.05  # seconds of a call from which one attempt suffices: disturbances are shorter
SAMPLES = 14  # least per side: two disturbed ones do not hide a slower head
LONG_STEPS = 100_000
DRIVEN = "driven_oscillator"
LONG_RUNS = 50  # times the ordinary duration, of an integrator without a step
LONG_SECONDS = 10.0  # of a long run, estimated from the ordinary one
LONG_ROUNDING = 1e-3  # of the floor of errors, times steps^1.5: a phase that errs at random
LEAST_LONGER = 2  # times the ordinary duration; a shorter one would show nothing


@dataclass
class Pair:
    """A benchmark on both sides; each mapping is by side.

    Attributes
    ----------
    runs
        results of all runs, see the worker's program: one in the first process, or two of those
        that are timed, and one in each further process
    why
        the reasons of failed sides
    rounds
        for each round, the samples in seconds
    notes
        sentences on what was run
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
        """The first run of each side that made all of its first calls."""
        return {side: runs[0] for side, runs in self.runs.items() if len(runs) >= self.first_calls}

    @property
    def complete(self) -> bool:
        """Whether both sides made their first calls."""
        return len(self.reached) == len(SIDES)

    @property
    def repeatable(self) -> bool:
        """Whether both sides ran it, and runs it twice."""
        return not self.why and self.case.kind not in UNTIMED

    @property
    def timed(self) -> bool:
        """Whether both sides have samples."""
        return bool(self.rounds) and not self.why

    def samples(self, at: int) -> tuple[list[float], list[float]]:
        """The samples of base and head in one of the rounds."""
        return self.rounds[at]["base"], self.rounds[at]["head"]

    @property
    def depends_on_process(self) -> bool:
        """Whether one of the sides reached another end in a further process."""
        return any(self.differs(side, FURTHER_PROCESSES) for side in SIDES)

    def differs(self, side: str, runs: slice) -> bool:
        """Whether one of these runs reached another end than the first one, by any bit."""
        first, further = self.runs[side][0]["ends"], self.runs[side][runs]
        return any(not np.array_equal(first, run["ends"], True) for run in further)


SECOND, FURTHER_PROCESSES = slice(1, 2), slice(2, None)  # of the runs of a side


def run_pairs(
    workers: Mapping[str, Worker], pairs: Sequence[Pair], report: Report, further: bool = False
) -> None:
    """Make the first calls of each benchmark on both sides; `further`: run it once more, in workers
    which are not those of its first calls."""
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
    """One run of LONG_STEPS steps of each integrator that is not galvi, on the driven oscillator,
    where a clock that goes wrong late shows, or else the first benchmark that both sides ran;
    shorter where the ordinary run was so slow that it would exceed LONG_SECONDS, or a third of the
    time limit of an answer.
    """
    able = [pair for pair in pairs if pair.case.contender and pair.repeatable]
    able.sort(key=lambda pair: pair.case.problem != DRIVEN)
    first: dict[str, Pair] = {}
    for pair in able:
        first.setdefault(pair.case.contender, pair)
    long = [longer for pair in first.values() if (longer := _longer(pair, limit))]
    run_pairs(workers, long, report)
    return long


def _longer(pair: Pair, limit: float) -> Pair | None:
    """The long run that a pair's speed allows; None, and a note there, where it allows none."""
    case = pair.case
    duration, step = case.step * case.steps, case.setting.get("step")
    wanted = int(LONG_RUNS if step is None else LONG_STEPS * step / duration)
    seconds = max(reached["warm"] for reached in pair.reached.values())
    times = min(wanted, int(min(LONG_SECONDS, limit / 3.0) / max(seconds, 1e-9)))
    if times < LEAST_LONGER <= wanted:
        sentence = f"No long run was made, because this one already takes {seconds:.2g} s."
        pair.notes += (sentence,)
    if times < LEAST_LONGER:
        return None
    setting = sampled(duration * times, case.setting, 1)
    name = f"{case.name}, {times} times as long"
    floor = max(1.0, LONG_ROUNDING * setting.get("save_every", LONG_STEPS) ** 1.5) * case.rounding
    long = replace(case, name=name, kind=LONG, steps=times, setting=setting, rounding=floor)
    shortened = f"Shortened from {wanted} times as long, to fit the time limit."
    return Pair(long, notes=(shortened,) if times < wanted else ())


def interleave(workers: Mapping[str, Worker], pairs: Sequence[Pair], report: Report) -> None:
    """Add a round of samples to each timed pair that both sides can run."""
    able = [pair for pair in pairs if pair.repeatable]
    for pair in able:
        pair.rounds.append({side: [] for side in SIDES})
    count = max(SAMPLES, samples_needed(len(able)))
    for k in range(count):
        report(f"samples {k + 1} of {count}")
        for pair, side in product(able, SIDES if k % 2 == 0 else SIDES[::-1]):
            if not pair.why:
                _sample(workers[side], pair, side)


def _sample(worker: Worker, pair: Pair, side: str) -> None:
    seconds = max(min(reached["warm"] for reached in pair.reached.values()), 1e-7)
    repeats, attempts = (
        max(1, math.ceil(SHORTEST_ATTEMPT / seconds)),
        1 if seconds > ONE_ATTEMPT else ATTEMPTS,
    )
    try:
        pair.rounds[-1][side].append(worker.time(pair.case, repeats, attempts))
    except Failed as error:
        pair.why[side] = str(error)
