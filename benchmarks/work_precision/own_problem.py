"""Work-precision of a problem of one's own: participants, settings and truth are found for it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

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
from benchmarks.work_precision.truths import Report, is_able, measure_of, truth_of
from galvi import Problem
from references import Contender, reference
from references.newton import is_differenced
from references.rebound import ias15, saba, whfast

OURS = (4, 8, 12)  # degrees
FIXED: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("REBOUND WHFast", whfast.BEST),
    ("REBOUND SABA", saba.BEST),
    ("REBOUND TRACE", {}),
    ("REBOUND leapfrog", {}),
    ("Stormer-Verlet", {}),
    ("RK4 on quaternions, compiled", {}),
    ("MuJoCo RK4", {}),
    ("MuJoCo Euler", {}),
    ("MuJoCo implicitfast", {}),
)
ADAPTIVE = (
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
)
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11)
OF_NEWTON = ("SciPy DOP853", "Stormer-Verlet")  # those that take the force of references.newton
DIFFERENCED = "Force differenced from the potential: with a gradient it takes less time."
COARSEST = 10  # steps
PATIENCE = 2.0  # seconds of the runs that find a contender's settings
COARSE, FINE = 0.1, 1e-13  # errors between which settings are of interest, relatively


def own_problem(
    problem: Problem, duration: float, quick: bool = False, report: Report = lambda sentence: None
) -> WorkPrecisionProblem:
    """galvi and every other code here that takes the problem, at settings found by trying them.

    Steps are halved from where a contender is within a tenth of the motion until it is as accurate
    as the truth, or takes PATIENCE. Raises ValueError where no code but galvi solves the problem,
    or none reaches the end.
    """
    truth = truth_of(problem, duration, report)
    participants = []
    for label, contender, options in _fixed():
        if is_able(contender, problem):
            report(f"settings of {label}")
            ladder = _Ladder(problem, duration, contender, options, truth, quick)
            settings = ladder.settings()
            participants += [Participant(label, contender, settings)] if settings else []
    for name in ADAPTIVE:
        contender = reference(name)
        if is_able(contender, problem):
            chosen = adaptive("tolerance", TOLERANCES[1::2] if quick else TOLERANCES)
            participants.append(Participant(name, contender, chosen))
    if is_able(ias15.IAS15, problem):
        looser = [] if quick else [{**ias15.GLOBAL, "epsilon": one} for one in (1e-2, 1e-4)]
        chosen = [{"samples": 1, **one} for one in (*looser, ias15.DEFAULT)]
        participants.append(Participant("REBOUND IAS15", ias15.IAS15, chosen))
    return WorkPrecisionProblem(
        problem, duration, tuple(participants), lambda: truth, *measure_of(problem),
        repeated_run=True, refined=False,
        notes=dict.fromkeys(OF_NEWTON if is_differenced(problem) else (), DIFFERENCED),
    )  # fmt: skip


def _fixed() -> Iterator[tuple[str, Contender, Mapping[str, Any]]]:
    for degree in OURS:
        yield galvi_label(degree), gauss_collocation(degree), {}
    for name, options in FIXED:
        yield name, reference(name), options


@dataclass
class _Ladder:
    """Numbers of equal steps that a contender may be shown at, found by trying them."""

    problem: Problem
    duration: float
    contender: Contender
    options: Mapping[str, Any]
    truth: Truth
    quick: bool
    found: list[Setting] = field(default_factory=list)

    def settings(self) -> list[Setting]:
        """From coarse to fine; the finest that was tried where all are too coarse."""
        _, distance = measure_of(self.problem)
        size = max(float(np.max(np.abs(self.truth.end))), float(np.max(np.abs(self.problem.q0))))
        floor = max(self.truth.error, FINE * size)
        begun, count, tried = math.inf, COARSEST, dict[str, Any]()
        while time.process_time() - begun < PATIENCE:
            tried = {**fixed(self.duration, count), **self.options}
            try:
                run = self.contender.run(self.problem, self.duration, tried)
            except ValueError:  # steps that it does not take
                break
            begun = min(begun, time.process_time())  # from the end of the first run: it may compile
            off = distance(run.q[-1], self.truth.end) if run.success else math.inf
            usable = off <= COARSE * size
            self.found += [tried] if usable else []
            if off <= floor:
                break
            count *= 2 if usable else 4
        if self.quick:
            return self.found[1:4:2] or self.found or [tried]
        return self.found or [tried]
