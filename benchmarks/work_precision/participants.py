"""Outsiders' places in studies, and the calls by which any contender is run and timed.

In a comparison at matched error an outsider runs at every setting that it offers; in a study of one
thing, such as energy over a long time, at the finest.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from benchmarks.work_precision.problem import Entry, Setting, WorkPrecisionProblem
from galvi import Problem, Trajectory
from references import Contender


class Participant(Contender, Protocol):
    """A contender from outside, such as `benchmarks.external.integrator.ExternalIntegrator`."""

    def settings(self, problem: Problem, duration: float, fewest: int) -> Sequence[Setting]:
        """What to run it with, from coarse to fine."""


FEWEST = 100  # steps, where no other contender takes equal ones
PATIENCE = 120.0  # seconds that the runs of an ensemble may take before no further one is begun


def with_outsiders(
    arena: WorkPrecisionProblem, outsiders: Sequence[Participant]
) -> WorkPrecisionProblem:
    """The arena with those that support its problem and say what to run them with."""
    taken = [label for label, _, _ in arena.entries]
    steps = [one["save_every"] for _, _, ladder in arena.entries for one in ladder if "step" in one]
    fewest = min(steps, default=FEWEST)
    entries: list[Entry] = []
    for outsider in outsiders:
        settings = offers(outsider, arena.problem, arena.duration, fewest)
        entries += [(label_beside(outsider, taken), outsider, settings)] if settings else []
    return replace(arena, entries=(*arena.entries, *entries))


def offers(
    outsider: Participant, problem: Problem, duration: float, fewest: int = FEWEST
) -> Sequence[Setting]:
    """What to run it with, from coarse to fine; nothing where it does not support the problem."""
    if not outsider.supports(problem):
        return []
    return outsider.settings(problem, duration, fewest)


def finest(
    outsider: Participant,
    problem: Problem,
    duration: float,
    parts: int,
    fewest: int = FEWEST,
) -> Setting | None:
    """The last of its settings, `sampled`; None where it does not take part."""
    offered = offers(outsider, problem, duration, fewest)
    return sampled(duration, offered[-1], parts) if offered else None


def sampled(duration: float, setting: Setting, parts: int) -> Setting:
    """A setting for the states at the ends of so many equal parts of the duration.

    Of equal steps it has the number next to the setting's that the parts divide.
    """
    if "step" not in setting:
        return {**setting, "samples": parts}
    steps = max(1, round(duration / setting["step"] / parts)) * parts
    return {**setting, "step": duration / steps, "save_every": steps // parts}


def ensemble(
    outsider: Participant,
    problems: Iterable[Problem],
    duration: float,
    parts: int,
    fewest: int,
) -> Iterator[tuple[Setting, Trajectory]]:
    """Its run from each start at its finest setting, until one fails or PATIENCE is over.

    problems  alike but for their starts
    """
    began, setting = time.perf_counter(), None
    for problem in problems:
        setting = setting or finest(outsider, problem, duration, parts, fewest)
        if setting is None:
            return
        run = outsider.run(problem, duration, setting)
        yield setting, run
        if not run.success or time.perf_counter() - began > PATIENCE:
            return


def label_beside(outsider: Participant, taken: Collection[str]) -> str:
    """Its name, which says that it is an outsider where a contender of ours has the same."""
    return f"{outsider.name}, outside" if outsider.name in taken else outsider.name


def readable_setting(setting: Mapping[str, Any]) -> str:
    """E.g. 'step=8.0003 corrector=17'; what every run shares is left out."""
    shown = {k: v for k, v in setting.items() if k not in ("save_every", "samples")}
    return " ".join(
        f"{k}={v:.5g}" if isinstance(v, float) else f"{k}={v}" for k, v in shown.items()
    )
