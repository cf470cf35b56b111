"""Samples of two sides that take turns, A B B A, so that a slow moment hits both alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.timings.case import ROUND_OFF, Case
from reports.tracking.side import Failed, Side

LEAST = 0.01  # seconds of a go
GOES = 3  # in a sample, of which the quickest counts
LONG = 0.05  # seconds of a call of which one is enough: what disturbs it is short

Told = Callable[[str], None]


@dataclass
class Pair:
    """What both sides told of one case.

    base, head  what their first calls reached, see the worker; None where they failed
    why         a sentence for each side that failed
    samples     for each round of samples, seconds of the base and of the head
    walls       the same by the wall clock
    """

    case: Case
    base: dict[str, Any] | None = None
    head: dict[str, Any] | None = None
    why: dict[str, str] = field(default_factory=dict)
    samples: list[tuple[list[float], list[float]]] = field(default_factory=list)
    walls: list[tuple[list[float], list[float]]] = field(default_factory=list)

    @property
    def timed(self) -> bool:
        """Whether both sides have samples worth comparing."""
        return bool(self.samples) and not self.why and all(map(len, self.samples[0]))


def prepare(sides: Mapping[str, Side], cases: Sequence[Case], report: Told) -> list[Pair]:
    """Each case's first call on either side."""
    pairs = []
    for case in cases:
        report(f"first calls: {case.name}")
        pair = Pair(case)
        for name, side in sides.items():
            try:
                setattr(pair, name, side.prepare(case))
            except Failed as error:
                pair.why[name] = str(error)
        pairs.append(pair)
    return pairs


def take_turns(sides: Mapping[str, Side], pairs: Sequence[Pair], count: int, report: Told) -> None:
    """Add a round of samples to each pair that both sides can run and that is timed at all."""
    able = [pair for pair in pairs if not pair.why and pair.case.kind != ROUND_OFF]
    sizes = {}
    for pair in able:
        assert pair.base and pair.head
        quickest = min(pair.base["warm"], pair.head["warm"])
        repeats = max(1, math.ceil(LEAST / max(quickest, 1e-7)))
        sizes[pair.case.name] = (repeats, 1 if quickest > LONG else GOES)
        pair.samples.append(([], []))
        pair.walls.append(([], []))
    for k in range(count):
        report(f"samples {k + 1} of {count}")
        order = (("base", 0), ("head", 1)) if k % 2 == 0 else (("head", 1), ("base", 0))
        for pair in able:
            name = pair.case.name
            for side, place in order:
                if pair.why:
                    continue
                try:
                    told = sides[side].sample(name, *sizes[name])
                except Failed as error:
                    pair.why[side] = str(error)
                    continue
                pair.samples[-1][place].append(told["processor"])
                pair.walls[-1][place].append(told["wall"])
