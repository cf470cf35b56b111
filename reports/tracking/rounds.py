"""Interleaved samples of two sides, A B B A, so that disturbances affect both alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.statistics.rank_test import samples_needed
from benchmarks.timings.case import ROUND_OFF, Case
from reports.tracking.worker import Failed, Worker

SIDES = ("base", "head")
LEAST = 0.01  # shortest attempt in seconds
ATTEMPTS = 3  # per sample, of which the fastest counts
LONG = 0.05  # seconds of a call from which one attempt suffices: disturbances are shorter
SAMPLES = 14  # least per side: two disturbed ones do not hide a slower head

Report = Callable[[str], None]


@dataclass
class Pair:
    """A benchmark on both sides; each mapping is by side.

    reached  results of the first calls, see the worker's program; without a side that failed
    again    results of a second run of those that are no round-off runs
    why      the reasons of failed sides
    rounds   for each round, the samples in seconds
    """

    case: Case
    reached: dict[str, dict[str, Any]] = field(default_factory=dict)
    again: dict[str, Any] = field(default_factory=dict)
    why: dict[str, str] = field(default_factory=dict)
    rounds: list[dict[str, list[float]]] = field(default_factory=list)


def first_calls(workers: Mapping[str, Worker], cases: Sequence[Case], report: Report) -> list[Pair]:
    """Make the first call of each benchmark on both sides."""
    pairs = []
    for case in cases:
        report(f"first calls: {case.name}")
        pair = Pair(case)
        for side in SIDES:
            try:
                pair.reached[side] = workers[side].run(case)
                if case.kind != ROUND_OFF:
                    pair.again[side] = workers[side].run(case)
            except Failed as error:
                pair.why[side] = str(error)
                pair.reached.pop(side, None)
        pairs.append(pair)
    return pairs


def interleave(workers: Mapping[str, Worker], pairs: Sequence[Pair], report: Report) -> None:
    """Add a round of samples to each timed pair that both sides can run."""
    able = [pair for pair in pairs if not pair.why and pair.case.kind != ROUND_OFF]
    for pair in able:
        pair.rounds.append({side: [] for side in SIDES})
    count = max(SAMPLES, samples_needed(len(able)))
    for k in range(count):
        report(f"samples {k + 1} of {count}")
        for pair in able:
            for side in SIDES if k % 2 == 0 else SIDES[::-1]:
                if not pair.why:
                    _sample(workers[side], pair, side)


def _sample(worker: Worker, pair: Pair, side: str) -> None:
    seconds = max(min(reached["warm"] for reached in pair.reached.values()), 1e-7)
    repeats, attempts = max(1, math.ceil(LEAST / seconds)), 1 if seconds > LONG else ATTEMPTS
    try:
        pair.rounds[-1][side].append(worker.time(pair.case, repeats, attempts))
    except Failed as error:
        pair.why[side] = str(error)
