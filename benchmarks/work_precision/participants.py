"""How external integrators take part in studies.

In a comparison at matched error they run at every setting that they offer; in a study of one thing,
such as energy over a long time, at the finest.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from benchmarks.work_precision.problem import Participant, Setting, WorkPrecisionProblem
from galvi import Problem, Trajectory
from references import Contender


class ExternalContender(Contender, Protocol):
    """A contender that says itself which settings it is run with.

    See `benchmarks.external.integrator.ExternalIntegrator`.
    """

    def settings(self, problem: Problem, duration: float, fewest: int) -> Sequence[Setting]:
        """What to run it with, from coarse to fine."""


FEWEST = 100  # steps, where no other contender takes equal ones
PATIENCE = 120.0  # seconds that the runs of an ensemble may take before no further one is begun


def with_externals(
    case: WorkPrecisionProblem, externals: Sequence[ExternalContender]
) -> WorkPrecisionProblem:
    """The case with those that support its problem and say what to run them with."""
    taken = [one.label for one in case.participants]
    offered = [setting for one in case.participants for setting in one.settings]
    steps = [setting["save_every"] for setting in offered if "step" in setting]
    fewest = min(steps, default=FEWEST)
    participants: list[Participant] = []
    for external in externals:
        settings = offered_settings(external, case.problem, case.duration, fewest)
        if settings:
            participants.append(Participant(label_beside(external, taken), external, settings))
    return replace(case, participants=(*case.participants, *participants))


def offered_settings(
    external: ExternalContender, problem: Problem, duration: float, fewest: int = FEWEST
) -> Sequence[Setting]:
    """What to run it with, from coarse to fine; nothing where it does not support the problem."""
    if not external.supports(problem):
        return []
    return external.settings(problem, duration, fewest)


def finest(
    external: ExternalContender,
    problem: Problem,
    duration: float,
    parts: int,
    fewest: int = FEWEST,
) -> Setting | None:
    """The last of its settings, `sampled`; None where it does not take part."""
    offered = offered_settings(external, problem, duration, fewest)
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
    external: ExternalContender,
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
        setting = setting or finest(external, problem, duration, parts, fewest)
        if setting is None:
            return
        run = external.run(problem, duration, setting)
        yield setting, run
        if not run.success or time.perf_counter() - began > PATIENCE:
            return


def label_beside(external: ExternalContender, taken: Collection[str]) -> str:
    """Its name, marked where a contender of the suite has the same."""
    return f"{external.name}, external" if external.name in taken else external.name


def readable_setting(setting: Mapping[str, Any]) -> str:
    """E.g. 'step=8.0003 corrector=17'; what every run shares is left out."""
    shown = {k: v for k, v in setting.items() if k not in ("save_every", "samples")}
    return " ".join(
        f"{k}={v:.5g}" if isinstance(v, float) else f"{k}={v}" for k, v in shown.items()
    )
