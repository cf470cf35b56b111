"""The reference solution of a user's problem, and its error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import galvi
from benchmarks.checks.claim import Report
from benchmarks.measures.errors import largest
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

# Codes that may be the truth, the best first, with their most accurate settings.
TRUTHS: Mapping[str, Mapping[str, Any]] = {
    "oscillator, closed form": {},
    "Kepler, closed form": {},
    "pendulum, closed form": {},
    "free rigid body, closed form": {},
    "thrown body, closed form": {},
    "heyoka, quadruple precision": {},
    "heyoka, chains, quadruple precision": {},
    "heyoka, Lagrangians, quadruple precision": {},
    "heyoka, rigid bodies, quadruple precision": {},
    "REBOUND IAS15": ias15.DEFAULT,
    "DOP853 on quaternions, compiled": {"tolerance": 1e-15},
    "SciPy DOP853 on MuJoCo's accelerations": {"tolerance": 1e-13},
    "SciPy DOP853 on Pinocchio's accelerations": {"tolerance": 1e-13},
    "SciPy DOP853": ivp.TIGHT,
    "SciPy DOP853, chains": {"tolerance": 1e-13},
    "SciPy DOP853, Lagrangians": {"tolerance": 1e-13},
    "SciPy DOP853, quaternions": ivp.TIGHT,
}
DIFFERENCED_SETTING = {"tolerance": 1e-9}  # a differenced force is no smoother than that
SAME_MOTION_DISTANCE = 1e-8  # relative distance of ends up to which runs follow the same motion
LOOSER_FACTOR = 30.0  # ratio of tolerances of a truth that is compared with itself
LEAST_STEPS, DOUBLINGS = 16, 10  # of the coarsest run of a pair, and most doublings
CLOSED = "closed form"  # part of the names of closed forms
SAMPLES = 32  # states of an accurate motion
State = tuple[Array, Array | None]  # q and p


def measure_of(problem: Problem) -> tuple[str, Callable[[Array, Array], float]]:
    """The quantity of the error, and the distance of two configurations."""
    if isinstance(problem.system, NBody):
        return POSITION, farthest_body
    if isinstance(problem.system, RigidBody):
        return ATTITUDE, largest_difference
    is_vector = problem.q0.ndim == 1 and problem.q0.shape == problem.v0.shape
    return COORDINATES if is_vector else MOTION, largest_difference


def can_run(contender: Contender, problem: Problem) -> bool:
    """Whether its engine is installed and it solves the problem."""
    return not contender.missing and contender.supports(problem)


def truth_setting(contender: Contender, problem: Problem) -> Mapping[str, Any]:
    """Its most accurate setting on the problem, of those in TRUTHS."""
    differenced = contender.name == "SciPy DOP853" and is_differenced(problem)
    return DIFFERENCED_SETTING if differenced else TRUTHS[contender.name]


def truth_of(problem: Problem, duration: float, report: Report) -> Truth:
    """The end by the first code of TRUTHS that reaches it.

    Its error is the difference from the second code, or from itself at a looser tolerance.
    ValueError where no code but galvi solves the problem or reaches the end.
    """
    _, distance = measure_of(problem)
    ends: list[tuple[str, Mapping[str, Any], Array, Array]] = []
    reason = ""
    for name in TRUTHS:
        if len(ends) == 2 or not can_run(reference(name), problem):
            continue
        report(f"truth: {name}")
        setting = truth_setting(reference(name), problem)
        try:
            run = reference(name).run(problem, duration, {"samples": 1, **setting})
        except ValueError as error:  # a truth that knows some starts or durations only
            reason = str(error)
            continue
        if run.success:
            ends.append((name, setting, run.q[-1], run.p[-1]))
        reason = run.status
    if not ends:
        raise ValueError(
            f"{problem.name} needs a truth that is not galvi's; received a "
            f"{type(problem.system).__name__}, which "
            + (
                f"no other code here carries to the end: {reason}"
                if reason
                else "no other code here solves."
            )
        )
    name, setting, end, momenta = ends[0]
    source = (name, readable_setting(setting))
    rounding = _rounding(end)
    if len(ends) == 2:
        second = ends[1]
        difference = distance(second[2], end)
        text = f"{name}; by its difference from {second[0]}"
        return Truth(end, max(difference, rounding), text, source, momenta)
    looser = {
        key: LOOSER_FACTOR * value for key, value in setting.items() if key in ("tolerance", "rtol")
    }
    if not looser:
        return Truth(end, rounding, f"{name}; to rounding", source, momenta)
    run = reference(name).run(problem, duration, {"samples": 1, **setting, **looser})
    difference = distance(run.q[-1], end)
    text = f"{name}; by its difference from itself at {LOOSER_FACTOR:g} times the tolerance"
    return Truth(end, max(difference, rounding), text, source, momenta)


def state_distance(
    problem: Problem, end: State, motion: Trajectory | None
) -> Callable[[State], float]:
    """A function that returns the distance of a state from the state at the end.

    It is the larger of the distances of the configurations and of the momenta, in units in which
    both have the same size; that of the configurations where momenta are unknown.

    Parameters
    ----------
    motion
        a run whose largest q and p give these units; None: those of the end

    Notes
    -----
    At a turning point the configuration alone is right to the square of the error in time.
    """
    _, distance = measure_of(problem)
    q, p = end
    size, unit = (
        (size_of(problem, q), 0.0 if p is None else max(largest(p), largest(problem.p0)))
        if motion is None
        else (largest(motion.q), largest(motion.p))
    )

    def from_end(state: State) -> float:
        difference = distance(state[0], q)
        if p is None or state[1] is None or not unit:
            return difference
        return max(difference, size / unit * largest(state[1] - p))

    return from_end


def size_of(problem: Problem, end: Array) -> float:
    """The largest entry of the configurations at start and end; 1 where all are 0."""
    return max(largest(end), largest(problem.q0)) or 1.0


def best_truth(problem: Problem, duration: float, method: galvi.Galerkin, report: Report) -> Truth:
    """The best truth of the end of a motion.

    It is that of a closed form; otherwise of an exact engine, with the smaller of its differences
    from its second source and from the finest pair of galvi's runs (`_pair`); otherwise that pair,
    compared with another code; otherwise that code.

    Raises
    ------
    ValueError
        Where no code and no pair reaches the end.
    """
    try:
        independent = truth_of(problem, duration, report)
    except ValueError:
        independent = None
    name = independent.source[0] if independent and independent.source else ""
    if independent and CLOSED in name:
        return replace(
            independent, error=_rounding(independent.end), description=f"{name}, to rounding"
        )
    try:
        run, error, text = _pair(problem, duration, method, report)
    except ValueError:
        if independent is None:
            raise
        return independent
    pair = Truth(run.q[-1], error, f"{text}, by their difference", None, run.p[-1])
    if independent is None:
        return replace(pair, description=f"{pair.description}; no other code here solves it")
    from_end = state_distance(problem, (independent.end, independent.momenta), run)
    difference = from_end((run.q[-1], run.p[-1]))
    if reference(name).exact:
        agreement = max(difference, error)
        description = f"{name}; by its difference from {text}"
        return (
            replace(independent, error=agreement, description=description)
            if agreement < independent.error
            else independent
        )
    if difference > 3.0 * independent.error:
        description = f"{text}; by its difference from {independent.description}"
        return replace(pair, error=max(difference, error), description=description)
    return replace(pair, description=f"{pair.description}; {name} agrees to {difference:.1g}")


def _pair(
    problem: Problem, duration: float, method: galvi.Galerkin, report: Report
) -> tuple[Trajectory, float, str]:
    """A run of a method, its error by a Richardson pair, and a description.

    The number of steps is doubled until the difference of successive runs is small and no longer
    falls to a quarter, which is round-off, or DOUBLINGS times. The error is the larger of the last
    two differences.

    Raises
    ------
    ValueError
        Where no pair comes to its end.
    """
    runs: list[Trajectory] = []
    differences: list[float] = []
    status = ""
    for count in (LEAST_STEPS * 2**k for k in range(DOUBLINGS + 1)):
        report(f"truth: {method.name}, {count} steps")
        save_every = count // LEAST_STEPS
        run = galvi.integrate(problem, method, duration / count, count, save_every=save_every)
        status = run.status
        if not run.success:
            runs, differences = [], []
            continue
        from_end = state_distance(problem, (run.q[-1], run.p[-1]), run)
        differences += [from_end((coarser.q[-1], coarser.p[-1])) for coarser in runs[-1:]]
        runs.append(run)
        is_small = len(differences) > 1 and differences[-2] < SAME_MOTION_DISTANCE * size_of(
            problem, run.q[-1]
        )
        if is_small and differences[-1] > 0.25 * differences[-2]:
            break
    if not differences:
        raise ValueError(
            f"{problem.name or 'the problem'} needs a truth; galvi's runs for one do not come to "
            f"their end, the last of them: {status} Give truth=, the configuration at the end."
        )
    text = f"galvi's {method.name} at {count // 2:,} and {count:,} steps (a Richardson pair)"
    return runs[-1], max(*differences[-2:], _rounding(runs[-1].q[-1])), text


def accurate_motion(problem: Problem, duration: float, truth: Truth) -> Trajectory | None:
    """States along a motion that ends at the truth, to find conserved quantities; None where no run
    does."""
    if truth.source is not None and truth.source[0] in TRUTHS:
        contender = reference(truth.source[0])
        setting = {"samples": SAMPLES, **truth_setting(contender, problem)}
        run = contender.run(problem, duration, setting)
        return run if run.success else None
    _, distance = measure_of(problem)
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    for count in (2 * SAMPLES * 4**k for k in range(5)):
        run = galvi.integrate(problem, method, duration / count, count, save_every=count // SAMPLES)
        tolerance = SAME_MOTION_DISTANCE * size_of(problem, truth.end)
        if run.success and distance(run.q[-1], truth.end) <= tolerance:
            return run
    return None


def _rounding(end: Array) -> float:
    return EPS * max(1.0, largest(end))
