"""The truth of a problem of one's own: which code gives it, and how accurately it is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import (
    ATTITUDE,
    COORDINATES,
    EPS,
    MOTION,
    POSITION,
    Truth,
    farthest_body,
    largest_difference,
)
from galvi import NBody, Problem, RigidBody
from galvi.arrays import Array
from references import Contender, reference
from references.rebound import ias15
from references.scipy import ivp

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

Report = Callable[[str], None]


def measure_of(problem: Problem) -> tuple[str, Callable[[Array, Array], float]]:
    """The quantity of the error, and the distance."""
    if isinstance(problem.system, NBody):
        return POSITION, farthest_body
    if isinstance(problem.system, RigidBody):
        return ATTITUDE, largest_difference
    flat = problem.q0.ndim == 1 and problem.q0.shape == problem.v0.shape
    return COORDINATES if flat else MOTION, largest_difference


def is_able(contender: Contender, problem: Problem) -> bool:
    """Whether its engine is here and it takes the problem."""
    return not contender.missing and contender.supports(problem)


def truth_of(problem: Problem, duration: float, report: Report) -> Truth:
    """The end by the first code that reaches it; its error by the second, or by itself at a
    looser tolerance.

    Its `source` names the code in TRUTHS. Raises ValueError where no code but galvi solves the
    problem, or none reaches the end.
    """
    _, distance = measure_of(problem)
    ends: list[tuple[str, Mapping[str, Any], Array]] = []
    said = ""
    for name, setting in TRUTHS:
        if len(ends) == 2 or not is_able(reference(name), problem):
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
