"""The truth of a problem of one's own, and how good it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import galvi
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
from references.newton import is_differenced
from references.rebound import ias15
from references.scipy import ivp

Report = Callable[[str], None]
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
ROUGH = {"tolerance": 1e-9}  # of a force that is differenced, and so no smoother than that
LOOSER = 30.0  # by which a tolerance differs where a truth is compared with itself


def measure_of(problem: Problem) -> tuple[str, Callable[[Array, Array], float]]:
    """The quantity of the error, and the distance."""
    if isinstance(problem.system, NBody):
        return POSITION, farthest_body
    if isinstance(problem.system, RigidBody):
        return ATTITUDE, largest_difference
    flat = problem.q0.ndim == 1 and problem.q0.shape == problem.v0.shape
    return COORDINATES if flat else MOTION, largest_difference


def can_run(contender: Contender, problem: Problem) -> bool:
    """Whether its engine is here and it solves the problem."""
    return not contender.missing and contender.supports(problem)


def truth_of(problem: Problem, duration: float, report: Report) -> Truth:
    """The end by the first code that reaches it; its error by the second, or by itself at a
    looser tolerance."""
    _, distance = measure_of(problem)
    ends: list[tuple[str, Mapping[str, Any], Array]] = []
    said = ""
    for name, setting in TRUTHS:
        if len(ends) == 2 or not can_run(reference(name), problem):
            continue
        report(f"truth: {name}")
        if name == "SciPy DOP853" and is_differenced(problem):
            setting = ROUGH
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
    rounding = _rounding(end)
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


FINEST, DOUBLINGS = 16, 5  # fewest steps of a Richardson pair, and how often they are doubled


def exact_truth(problem: Problem, duration: float, report: Report) -> Truth | None:
    """The end by a closed form or by an engine that is exact; None where none is here."""
    for name, setting in TRUTHS:
        contender = reference(name)
        if not (contender.exact and can_run(contender, problem)):
            continue
        report(f"truth: {name}")
        try:
            run = contender.run(problem, duration, {"samples": 1, **setting})
        except ValueError:  # a truth that knows some starts or durations only
            continue
        if run.success and "closed form" in name:
            return Truth(run.q[-1], _rounding(run.q[-1]), f"{name}, to rounding")
        if run.success:
            return truth_of(problem, duration, report)
    return None


def confirmed_truth(
    problem: Problem, duration: float, exact: Truth, method: galvi.Galerkin, steps: int,
    report: Report,
) -> Truth:  # fmt: skip
    """The truth of an exact engine, with its difference from a pair of galvi's runs as its error
    where this, and the pair's own error, are smaller than the difference from another code."""
    try:
        end, error, text = _pair(problem, duration, method, steps, report)
    except ValueError:
        return exact
    _, distance = measure_of(problem)
    apart = max(distance(end, exact.end), error)
    if apart >= exact.error:
        return exact
    name = (exact.source or (exact.description,))[0]
    return Truth(exact.end, apart, f"{name}; by its difference from {text}", exact.source)


def richardson_truth(
    problem: Problem, duration: float, method: galvi.Galerkin, steps: int, report: Report
) -> Truth:
    """The end by the finest pair of a method's runs, see `_pair`; the error is the larger of the
    last two differences.

    Where a code that is not galvi solves the problem too and differs by more than its own error,
    that difference is. Raises ValueError where no pair comes to its end.
    """
    end, error, text = _pair(problem, duration, method, steps, report)
    try:
        other = truth_of(problem, duration, report)
    except ValueError:
        return Truth(
            end, error, f"{text}, by their difference; no other code here solves the problem"
        )
    _, distance = measure_of(problem)
    off = distance(other.end, end)
    if off > 3.0 * other.error:
        return Truth(end, max(off, error), f"{text}; by its difference from {other.description}")
    name = (other.source or (other.description,))[0]
    return Truth(end, error, f"{text}, by their difference; {name} agrees to {off:.1g}")


def _pair(
    problem: Problem, duration: float, method: galvi.Galerkin, steps: int, report: Report
) -> tuple[Array, float, str]:
    """The end by a method at a number of steps and at twice as many, doubled until the difference
    of the pair no longer falls to a quarter, which is round-off, or DOUBLINGS times; the larger one
    of the last two differences; and a text. Raises ValueError where no pair comes to its end."""
    _, distance = measure_of(problem)
    ends: list[Array] = []
    apart: list[float] = []
    status = ""
    for count in (max(FINEST, steps) * 2**k for k in range(DOUBLINGS + 1)):
        report(f"truth: {method.name}, {count} steps")
        run = galvi.integrate(problem, method, duration / count, count, save_every=count)
        status = run.status
        if not run.success:
            ends, apart = [], []
            continue
        ends.append(run.q[-1])
        apart += [distance(ends[-2], ends[-1])] if len(ends) > 1 else []
        if len(apart) > 1 and apart[-1] > 0.25 * apart[-2]:
            break
    if not apart:
        raise ValueError(
            f"{problem.name or 'the problem'} needs a truth; no other code here solves it, and "
            f"galvi's run for one did not end: {status} Give truth=, the configuration at the end."
        )
    text = f"galvi's {method.name} at {count // 2:,} and {count:,} steps (a Richardson pair)"
    return ends[-1], max(*apart[-2:], _rounding(ends[-1])), text


def _rounding(end: Array) -> float:
    return EPS * max(1.0, float(np.max(np.abs(end))))
