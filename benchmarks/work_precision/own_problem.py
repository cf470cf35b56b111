"""Work-precision of a problem of one's own: participants, settings and truth are found for it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import (
    ATTITUDE,
    COORDINATES,
    EPS,
    MOTION,
    POSITION,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    farthest_body,
    fixed,
    galvi_label,
    largest_difference,
)
from galvi import NBody, Problem, RigidBody
from galvi.arrays import Array
from references import Contender, reference
from references.newton import is_differenced
from references.rebound import ias15, leapfrog, saba, whfast, whfast512
from references.scipy import ivp

OURS = (4, 8, 12)  # degrees
FIXED: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("REBOUND WHFast", whfast.BEST),
    ("REBOUND SABA", saba.BEST),
    ("REBOUND WHFast512", whfast512.BEST),
    ("REBOUND MERCURIUS", {}),
    ("REBOUND TRACE", {}),
    ("REBOUND leapfrog", leapfrog.BEST),
    ("Stormer-Verlet", {}),
    ("Forest-Ruth", {}),
    ("RK4", {}),
    ("RK4 on quaternions, compiled", {}),
    ("MuJoCo RK4", {}),
    ("MuJoCo Euler", {}),
    ("MuJoCo implicit", {}),
    ("MuJoCo implicitfast", {}),
)
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
)
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11)
OF_NEWTON = (
    "SciPy DOP853",
    "Stormer-Verlet",
    "Forest-Ruth",
    "RK4",
)  # those that take the force of references.newton
DIFFERENCED = "Force differenced from the potential: with a gradient it takes less time."
# What may be the truth, the best first, with its most accurate setting.
TRUTHS: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("oscillator, closed form", {}),
    ("Kepler, closed form", {}),
    ("pendulum, closed form", {}),
    ("free rigid body, closed form", {}),
    ("thrown body, closed form", {}),
    ("heyoka, quadruple precision", {}),
    ("heyoka, chains, quadruple precision", {}),
    ("heyoka, Lagrangians, quadruple precision", {}),
    ("heyoka, rigid bodies, quadruple precision", {}),
    ("REBOUND IAS15", ias15.DEFAULT),
    ("DOP853 on quaternions, compiled", {"tolerance": 1e-15}),
    ("SciPy DOP853 on MuJoCo's accelerations", {"tolerance": 1e-13}),
    ("SciPy DOP853 on Pinocchio's accelerations", {"tolerance": 1e-13}),
    ("SciPy DOP853", ivp.TIGHT),
    ("SciPy DOP853, chains", {"tolerance": 1e-13}),
    ("SciPy DOP853, Lagrangians", {"tolerance": 1e-13}),
    ("SciPy DOP853, quaternions", ivp.TIGHT),
)
LOOSER = 30.0  # by which a tolerance differs where a truth is compared with itself
COARSEST = 10  # steps
PATIENCE = 2.0  # seconds of the runs that find a contender's settings
COARSE, FINE = 0.1, 1e-13  # errors between which settings are of interest, relatively

Report = Callable[[str], None]


def own_problem(
    problem: Problem, duration: float, quick: bool = False, report: Report = lambda sentence: None
) -> WorkPrecisionProblem:
    """galvi and every other code here that takes the problem, at settings found by trying them.

    Steps are halved from where a contender is within a tenth of the motion until it is as accurate
    as the truth, or takes PATIENCE. Raises ValueError where no code but galvi solves the problem,
    or none reaches the end.
    """
    truth = _truth(problem, duration, report)
    participants = []
    for label, contender, options in _fixed():
        if _able(contender, problem):
            report(f"settings of {label}")
            ladder = _Ladder(problem, duration, contender, options, truth, quick)
            settings = ladder.settings()
            participants += [Participant(label, contender, settings)] if settings else []
    for name in ADAPTIVE:
        contender = reference(name)
        if _able(contender, problem):
            chosen = adaptive("tolerance", TOLERANCES[1::2] if quick else TOLERANCES)
            participants.append(Participant(name, contender, chosen))
    if _able(ias15.IAS15, problem):
        looser = [] if quick else [{**ias15.GLOBAL, "epsilon": one} for one in (1e-2, 1e-4)]
        chosen = [{"samples": 1, **one} for one in (*looser, ias15.DEFAULT)]
        participants.append(Participant("REBOUND IAS15", ias15.IAS15, chosen))
    return WorkPrecisionProblem(
        problem, duration, tuple(participants), lambda: truth, *_measure(problem),
        repeated_run=True, refined=False,
        notes=dict.fromkeys(OF_NEWTON if is_differenced(problem) else (), DIFFERENCED),
    )  # fmt: skip


def _measure(problem: Problem) -> tuple[str, Callable[[Array, Array], float]]:
    """The quantity of the error, and the distance."""
    if isinstance(problem.system, NBody):
        return POSITION, farthest_body
    if isinstance(problem.system, RigidBody):
        return ATTITUDE, largest_difference
    flat = problem.q0.ndim == 1 and problem.q0.shape == problem.v0.shape
    return COORDINATES if flat else MOTION, largest_difference


def _able(contender: Contender, problem: Problem) -> bool:
    return not contender.missing and contender.supports(problem)


def _fixed() -> Iterator[tuple[str, Contender, Mapping[str, Any]]]:
    for degree in OURS:
        yield galvi_label(degree), gauss_collocation(degree), {}
    for name, options in FIXED:
        yield name, reference(name), options


def _truth(problem: Problem, duration: float, report: Report) -> Truth:
    """The end by the first code that reaches it; its error by the second, or by itself at a
    looser tolerance."""
    _, distance = _measure(problem)
    ends: list[tuple[str, Mapping[str, Any], Array]] = []
    said = ""
    for name, setting in TRUTHS:
        if len(ends) == 2 or not _able(reference(name), problem):
            continue
        report(f"truth: {name}")
        try:
            run = reference(name).run(problem, duration, {"samples": 1, **setting})
        except ValueError as error:  # a truth that knows some starts or durations only
            said = str(error)
            continue
        if run.success:
            ends.append((name, setting, run.q[-1]))
        said = run.status
    if not ends:
        raise ValueError(
            f"{problem.name} needs a truth that is not galvi's; received a "
            f"{type(problem.system).__name__}, which "
            + (f"no other code here carries to the end: {said}" if said
               else "no other code here solves.")
        )  # fmt: skip
    name, setting, end = ends[0]
    source = (name, readable_setting(setting))
    rounding = EPS * max(1.0, float(np.max(np.abs(end))))
    if len(ends) == 2:
        other = ends[1]
        apart = distance(other[2], end)
        return Truth(
            end, max(apart, rounding), f"{name}; by its difference from {other[0]}", source
        )
    looser = {key: LOOSER * value for key, value in setting.items() if key in ("tolerance", "rtol")}
    if not looser:
        return Truth(end, rounding, f"{name}; to rounding", source)
    run = reference(name).run(problem, duration, {"samples": 1, **setting, **looser})
    apart = distance(run.q[-1], end)
    text = f"{name}; by its difference from itself at {LOOSER:g} times the tolerance"
    return Truth(end, max(apart, rounding), text, source)


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
        _, distance = _measure(self.problem)
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
