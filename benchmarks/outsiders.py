"""Outsiders' places in an arena, and the calls by which any contender is run and timed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from benchmarks.arena import Arena, Entry
from benchmarks.outsider import Outsider
from galvi import Problem, Trajectory
from references import Contender

FEWEST = 100  # steps, where no other contender takes equal ones


def call_of(
    contender: Contender, problem: Problem, duration: float, setting: Mapping[str, Any]
) -> Callable[[], Trajectory]:
    """A call that runs it; an outsider's knows its own time."""
    if isinstance(contender, Outsider):
        return contender.timed(problem, duration, setting)
    return partial(contender.run, problem, duration, setting)


def with_outsiders(arena: Arena, outsiders: Sequence[Outsider]) -> Arena:
    """The arena with those that support its problem and say what to run them with."""
    taken = [label for label, _, _ in arena.entries]
    steps = [one["save_every"] for _, _, ladder in arena.entries for one in ladder if "step" in one]
    fewest = min(steps, default=FEWEST)
    entries: list[Entry] = []
    for outsider in outsiders:
        if outsider.supports(arena.problem):
            label = f"{outsider.name}, outside" if outsider.name in taken else outsider.name
            settings = outsider.settings(arena.problem, arena.duration, fewest)
            entries += [(label, outsider, settings)] if settings else []
    return replace(arena, entries=(*arena.entries, *entries))
