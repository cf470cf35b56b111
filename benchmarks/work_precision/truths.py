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
from galvi import NBody, Problem, RigidBody, Trajectory
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
ALIKE = 1e-8  # relative distance of ends from which on runs are of one motion
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
    ends: list[tuple[str, Mapping[str, Any], Array, Array]] = []
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
            ends.append((name, setting, run.q[-1], run.p[-1]))
        said = run.status
    if not ends:
        raise ValueError(
            f"{problem.name} needs a truth that is not galvi's; received a "
            f"{type(problem.system).__name__}, which "
            + (f"no other code here carries to the end: {said}" if said
               else "no other code here solves.")
        )  # fmt: skip
    name, setting, end, momenta = ends[0]
    source = (name, readable_setting(setting))
    rounding = _rounding(end)
    if len(ends) == 2:
        other = ends[1]
        apart = distance(other[2], end)
        text = f"{name}; by its difference from {other[0]}"
        return Truth(end, max(apart, rounding), text, source, momenta)
    looser = {key: LOOSER * value for key, value in setting.items() if key in ("tolerance", "rtol")}
    if not looser:
        return Truth(end, rounding, f"{name}; to rounding", source, momenta)
    run = reference(name).run(problem, duration, {"samples": 1, **setting, **looser})
    apart = distance(run.q[-1], end)
    text = f"{name}; by its difference from itself at {LOOSER:g} times the tolerance"
    return Truth(end, max(apart, rounding), text, source, momenta)


LEAST_STEPS, DOUBLINGS = 16, 10  # of the coarsest run for a pair, and how often it is refined
CLOSED = "closed form"  # in the names of these
SAMPLES = 32  # states of an accurate motion
State = tuple[Array, Array | None]  # q and p


def state_distance(
    problem: Problem, end: State, motion: Trajectory | None
) -> Callable[[State], float]:
    """Distance of a state from that at the end: of the configurations, or of the momenta in units
    that make both of one size, whichever is larger; of the configurations where no p is known.

    motion  states along it, of which the largest q and p give these units; None: of the end alone

    At a turning point the configuration alone is right to the square of the error in time.
    """
    _, distance = measure_of(problem)
    q, p = end
    size, unit = (
        (size_of(problem, q), 0.0 if p is None else max(_largest(p), _largest(problem.p0)))
        if motion is None
        else (_largest(motion.q), _largest(motion.p))
    )

    def away(state: State) -> float:
        apart = distance(state[0], q)
        if p is None or state[1] is None or not unit:
            return apart
        return max(apart, size / unit * _largest(state[1] - p))

    return away


def size_of(problem: Problem, end: Array) -> float:
    """Of the configurations at start and end."""
    return max(_largest(end), _largest(problem.q0)) or 1.0


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
        if run.success and CLOSED in name:
            end, text = run.q[-1], f"{name}, to rounding"
            return Truth(end, _rounding(end), text, (name, ""), run.p[-1])
        if run.success:
            return truth_of(problem, duration, report)
    return None


def confirmed_truth(
    problem: Problem, duration: float, exact: Truth, method: galvi.Galerkin, report: Report
) -> Truth:
    """The truth of an exact engine, with its difference from a pair of galvi's runs as its error
    where this, and the pair's own error, are smaller than the difference from another code."""
    try:
        run, error, text = _pair(problem, duration, method, report)
    except ValueError:
        return exact
    away = state_distance(problem, (exact.end, exact.momenta), run)
    apart = max(away((run.q[-1], run.p[-1])), error)
    if apart >= exact.error or exact.source is None:
        return exact
    description = f"{exact.source[0]}; by its difference from {text}"
    return Truth(exact.end, apart, description, exact.source, exact.momenta)


def richardson_truth(
    problem: Problem, duration: float, method: galvi.Galerkin, report: Report
) -> Truth:
    """The end by the finest pair of a method's runs, see `_pair`; the error is the larger of the
    last two differences.

    Where a code that is not galvi solves the problem too and differs by more than its own error,
    that difference is; where no pair comes to its end, that code is the truth. Raises ValueError
    where there is none either.
    """
    try:
        run, error, text = _pair(problem, duration, method, report)
    except ValueError as no_pair:
        try:
            return truth_of(problem, duration, report)
        except ValueError:
            raise no_pair from None
    try:
        other = truth_of(problem, duration, report)
    except ValueError:
        text += ", by their difference; no other code here solves the problem"
        return Truth(run.q[-1], error, text, None, run.p[-1])
    _, distance = measure_of(problem)
    off = distance(other.end, run.q[-1])
    if off > 3.0 * other.error:
        text += f"; by its difference from {other.description}"
        return Truth(run.q[-1], max(off, error), text, None, run.p[-1])
    name = (other.source or (other.description,))[0]
    text += f", by their difference; {name} agrees to {off:.1g}"
    return Truth(run.q[-1], error, text, None, run.p[-1])


def _pair(
    problem: Problem, duration: float, method: galvi.Galerkin, report: Report
) -> tuple[Trajectory, float, str]:
    """The finer one of a method's runs at a number of steps and at twice as many, doubled until the
    difference of the pair no longer falls to a quarter, which is round-off, or DOUBLINGS times; the
    larger one of the last two differences; and a text. Raises ValueError where no pair comes to its
    end."""
    runs: list[Trajectory] = []
    apart: list[float] = []
    status = ""
    for count in (LEAST_STEPS * 2**k for k in range(DOUBLINGS + 1)):
        report(f"truth: {method.name}, {count} steps")
        every = count // LEAST_STEPS
        run = galvi.integrate(problem, method, duration / count, count, save_every=every)
        status = run.status
        if not run.success:
            runs, apart = [], []
            continue
        away = state_distance(problem, (run.q[-1], run.p[-1]), run)
        apart += [away((one.q[-1], one.p[-1])) for one in runs[-1:]]
        runs.append(run)
        small = len(apart) > 1 and apart[-2] < ALIKE * size_of(problem, run.q[-1])
        if small and apart[-1] > 0.25 * apart[-2]:
            break
    if not apart:
        raise ValueError(
            f"{problem.name or 'the problem'} needs a truth; galvi's runs for one do not come to "
            f"their end, the last of them: {status} Give truth=, the configuration at the end."
        )
    text = f"galvi's {method.name} at {count // 2:,} and {count:,} steps (a Richardson pair)"
    return runs[-1], max(*apart[-2:], _rounding(runs[-1].q[-1])), text


def accurate_motion(problem: Problem, duration: float, truth: Truth) -> Trajectory | None:
    """States along a motion that ends at the truth, to tell what the motion keeps; None where none
    comes so near."""
    settings = dict(TRUTHS)
    if truth.source is not None and truth.source[0] in settings:
        name = truth.source[0]
        run = reference(name).run(problem, duration, {"samples": SAMPLES, **settings[name]})
        return run if run.success else None
    _, distance = measure_of(problem)
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    for count in (2 * SAMPLES * 4**k for k in range(5)):
        run = galvi.integrate(problem, method, duration / count, count, save_every=count // SAMPLES)
        near = run.success and distance(run.q[-1], truth.end)
        if run.success and near <= ALIKE * size_of(problem, truth.end):
            return run
    return None


def _rounding(end: Array) -> float:
    return EPS * max(1.0, _largest(end))


def _largest(x: Array) -> float:
    return float(np.max(np.abs(x)))
