"""Participation of external integrators in studies.

In comparisons at matched error they run at every setting they offer; in studies of one property,
such as energy over long times, at the finest.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from benchmarks.store.foreign_texts import visible
from benchmarks.work_precision.problem import Participant, Setting, WorkPrecisionProblem
from galvi import Problem, Trajectory
from references import Contender


class ExternalContender(Contender, Protocol):
    """A contender that offers its own settings.

    See `benchmarks.applications.external.integrator.ExternalIntegrator`.
    """

    def settings(self, problem: Problem, duration: float, fewest: int) -> Sequence[Setting]:
        """The settings that it offers, from coarse to fine."""


FEWEST_STEPS = 100  # where no other contender takes equal steps
ENSEMBLE_SECONDS = 120.0  # seconds after which no further run of an ensemble is started


def with_externals(
    case: WorkPrecisionProblem, externals: Sequence[ExternalContender]
) -> WorkPrecisionProblem:
    """The case with the external integrators that support its problem and offer settings."""
    labels = [participant.label for participant in case.participants]
    offered = [setting for participant in case.participants for setting in participant.settings]
    steps = [setting["save_every"] for setting in offered if "save_every" in setting]
    fewest = min(steps, default=FEWEST_STEPS)
    participants: list[Participant] = []
    for external in externals:
        settings = [
            setting if "step" in setting else {"samples": 1, **setting}
            for setting in offered_settings(external, case.problem, case.duration, fewest)
        ]
        if settings:
            participants.append(Participant(label_beside(external, labels), external, settings))
    return replace(case, participants=(*case.participants, *participants))


def offered_settings(
    external: ExternalContender, problem: Problem, duration: float, fewest: int = FEWEST_STEPS
) -> Sequence[Setting]:
    """The integrator's settings, coarse to fine; none where it does not support the problem."""
    if not external.supports(problem):
        return []
    return external.settings(problem, duration, fewest)


def finest(
    external: ExternalContender,
    problem: Problem,
    duration: float,
    parts: int,
    fewest: int = FEWEST_STEPS,
) -> Setting | None:
    """The last of its settings, `sampled`; None when it does not take part."""
    offered = offered_settings(external, problem, duration, fewest)
    return sampled(duration, offered[-1], parts) if offered else None


def sampled(duration: float, setting: Setting, parts: int) -> Setting:
    """A setting that saves the states at the ends of `parts` equal parts of the duration.

    The number of equal steps is rounded to a multiple of `parts`.
    """
    if "step" not in setting:
        return {**setting, "samples": parts}
    steps = max(1, round(duration / setting["step"] / parts)) * parts
    return {**setting, "step": duration / steps, "save_every": steps // parts}


def ensemble(
    external: ExternalContender,
    problems: Iterable[Problem],
    duration: float,
    parts: int,
    fewest: int,
) -> Iterator[tuple[Setting, Trajectory]]:
    """Runs from each start at the finest setting, until one fails or ENSEMBLE_SECONDS have passed.

    Parameters
    ----------
    problems
        equal except for their initial states
    """
    start, setting = time.perf_counter(), None
    for problem in problems:
        setting = setting or finest(external, problem, duration, parts, fewest)
        if setting is None:
            return
        run = external.run(problem, duration, setting)
        yield setting, run
        if not run.success or time.perf_counter() - start > ENSEMBLE_SECONDS:
            return


def label_beside(external: ExternalContender, labels: Collection[str]) -> str:
    """The integrator's name, marked where one of the labels is the same up to case."""
    is_taken = external.name.casefold() in {label.casefold() for label in labels}
    return f"{external.name}, external" if is_taken else external.name


def readable_setting(setting: Mapping[str, Any]) -> str:
    """Text such as 'step=8.0003 corrector=17', without control characters; keys shared by all runs
    are omitted."""
    shown = {k: v for k, v in setting.items() if k not in ("save_every", "samples")}
    return visible(
        " ".join(f"{k}={v:.5g}" if isinstance(v, float) else f"{k}={v}" for k, v in shown.items())
    )
