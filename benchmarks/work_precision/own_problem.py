"""Work-precision of a user's problem: find its participants, settings and truth."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from benchmarks.checks.claim import Report
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
)
from benchmarks.work_precision.truths import can_run, measure_of, size_of, truth_of
from galvi import Problem
from references import Contender, reference
from references.newton import is_differenced
from references.rebound import ias15, leapfrog, saba, whfast, whfast512

GALVI_DEGREES = (4, 8, 12)
FIXED: Mapping[str, Mapping[str, Any]] = {  # of equal steps, with their best options
    "REBOUND WHFast": whfast.BEST,
    "REBOUND SABA": saba.BEST,
    "REBOUND WHFast512": whfast512.BEST,
    "REBOUND MERCURIUS": {},
    "REBOUND TRACE": {},
    "REBOUND leapfrog": leapfrog.BEST,
    "Stormer-Verlet": {},
    "Forest-Ruth": {},
    "RK4": {},
    "RK4 on quaternions, compiled": {},
    "MuJoCo RK4": {},
    "MuJoCo Euler": {},
    "MuJoCo implicit": {},
    "MuJoCo implicitfast": {},
}
ADAPTIVE = (
    "REBOUND BS",
    "SciPy DOP853",
    "SciPy DOP853, chains",
    "SciPy DOP853, Lagrangians",
    "SciPy DOP853, quaternions",
    "DOP853 on quaternions, compiled",
    "SciPy DOP853 on MuJoCo's accelerations",
    "SciPy DOP853 on Pinocchio's accelerations",
    "heyoka",
    "heyoka, chains",
    "heyoka, Lagrangians",
    "heyoka, rigid bodies",
    "REBOUND IAS15",
)
TOLERANCES = (1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
# Those that take the force of references.newton.
NEWTON_FORCE_CODES = ("SciPy DOP853", "Stormer-Verlet", "Forest-Ruth", "RK4")
DIFFERENCED_NOTE = "Force differenced from the potential: with a gradient it takes less time."
COARSEST_STEPS = 10  # steps
LADDER_SECONDS = 2.0  # seconds of the runs that find a contender's settings
LARGEST_ERROR, SMALLEST_ERROR = 0.1, 1e-13  # relative errors between which settings are shown


def own_problem(
    problem: Problem, duration: float, quick: bool = False, report: Report = lambda sentence: None
) -> WorkPrecisionProblem:
    """galvi and every other installed code that supports the problem, at settings found by trials.

    Steps are halved from where the error is a tenth of the motion until a contender is as accurate
    as the truth, or its trials take LADDER_SECONDS.

    Raises
    ------
    ValueError
        Where no code but galvi solves the problem, or none reaches the end.
    """
    truth = truth_of(problem, duration, report)
    participants = []
    for degree in GALVI_DEGREES:
        label, method = galvi_label(degree), gauss_collocation(degree)
        report(f"settings of {label}")
        settings = ladder(problem, duration, method, truth, quick)
        participants.append(Participant(label, method, settings))
    for contender in peers(problem):
        report(f"settings of {contender.name}")
        settings = (
            ladder(problem, duration, contender, truth, quick)
            if contender.name in FIXED
            else tolerances(contender, quick)
        )
        participants.append(Participant(contender.name, contender, settings))
    return WorkPrecisionProblem(
        problem,
        duration,
        tuple(participants),
        lambda: truth,
        *measure_of(problem),
        repeated_run=True,
        notes=dict.fromkeys(
            NEWTON_FORCE_CODES if is_differenced(problem) else (), DIFFERENCED_NOTE
        ),
    )


def peers(problem: Problem) -> list[Contender]:
    """Every code but galvi that is installed and supports the problem."""
    contenders = (reference(name) for name in (*FIXED, *ADAPTIVE))
    return [contender for contender in contenders if can_run(contender, problem)]


def tolerances(contender: Contender, quick: bool = False) -> list[Setting]:
    """Settings of a code that chooses its steps, from loose to tight."""
    if contender is ias15.IAS15:
        looser = [] if quick else [{**ias15.GLOBAL, "epsilon": epsilon} for epsilon in (1e-2, 1e-4)]
        return [{"samples": 1, **options} for options in (*looser, ias15.DEFAULT)]
    return adaptive("tolerance", TOLERANCES[1::2] if quick else TOLERANCES)


def ladder(
    problem: Problem,
    duration: float,
    contender: Contender,
    truth: Truth,
    quick: bool = False,
    options: Mapping[str, Any] | None = None,
) -> list[Setting]:
    """Settings of equal steps found by trials, each with half the step of the one before.

    They begin where the error is a tenth of the motion, and end where it is that of the truth, or
    the trials take LADDER_SECONDS.

    Parameters
    ----------
    options
        further entries of each setting; None for those in FIXED
    """
    options = FIXED.get(contender.name, {}) if options is None else options
    return _Ladder(problem, duration, contender, options, truth, quick).settings()


@dataclass
class _Ladder:
    """The search for the numbers of equal steps of a contender."""

    problem: Problem
    duration: float
    contender: Contender
    options: Mapping[str, Any]
    truth: Truth
    quick: bool
    usable_settings: list[Setting] = field(default_factory=list)

    def settings(self) -> list[Setting]:
        """The settings from coarse to fine; the finest that was tried where all are too coarse."""
        _, distance = measure_of(self.problem)
        size = size_of(self.problem, self.truth.end)
        floor = max(self.truth.error, SMALLEST_ERROR * size)
        start, count, setting = math.inf, COARSEST_STEPS, dict[str, Any]()
        in_other_process = hasattr(self.contender, "timed")  # in another process
        clock = time.perf_counter if in_other_process else time.process_time
        while clock() - start < LADDER_SECONDS:
            setting = {**fixed(self.duration, count), **self.options}
            try:
                run = self.contender.run(self.problem, self.duration, setting)
            except ValueError:  # steps that it does not take
                break
            start = min(start, clock())  # from the end of the first run: it may compile
            error = distance(run.q[-1], self.truth.end) if run.success else math.inf
            is_usable = error <= LARGEST_ERROR * size
            self.usable_settings += [setting] if is_usable else []
            if error <= floor:
                break
            count *= 2 if is_usable else 4
        if self.quick:
            return self.usable_settings[1:4:2] or self.usable_settings or [setting]
        return self.usable_settings or [setting]
