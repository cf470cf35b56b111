"""The problems on which another project's integrators are compared, and their benchmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.timings.case import ROUNDING_GROWTH, TRAJECTORY, Case, Thresholds
from benchmarks.timings.worker import problem_of
from benchmarks.work_precision.participants import finest
from reports.tracking.checkouts import CannotCompare


def tracked(
    problem: str,
    duration: float,
    truth: str,
    arguments: Mapping[str, Any] | None = None,
    truth_tolerance: float = 0.0,
    accuracy: float = 1.0,
) -> Case:
    """The case of a problem on which every integrator that supports it is compared.

    Parameters
    ----------
    problem
        name of a function in galvi.problems
    duration
        in the problem's unit of time
    truth
        name of a reference
    arguments
        arguments of the function
    tight
        tolerance of the reference; 0 for its default
    accuracy
        smallest error that is compared, over ROUNDING_GROWTH: larger for large motions and for less
        accurate truths
    """
    return Case(
        problem,
        TRAJECTORY,
        problem,
        0,
        0,
        duration,
        1,
        truth,
        arguments or {},
        truth_tolerance=truth_tolerance,
        rounding=ROUNDING_GROWTH * accuracy,
    )


# All of them start in motion, so that a reversed time would show.
PROBLEMS: tuple[Case, ...] = (
    tracked("harmonic_oscillator", 5.0, "oscillator, closed form", {"velocity": 0.5}),
    tracked("kepler", 5.0, "Kepler, closed form", {"eccentricity": 0.3}),
    tracked("planar_pendulum", 5.0, "pendulum, closed form", {"rate": -0.5}),
    tracked("henon_heiles", 5.0, "SciPy DOP853", truth_tolerance=1e-13, accuracy=10.0),
    tracked("driven_oscillator", 5.0, "SciPy DOP853", truth_tolerance=1e-13, accuracy=10.0),
    tracked("outer_solar_system", 7305.0, "REBOUND IAS15", accuracy=100.0),
    tracked("free_rigid_body", 5.0, "free rigid body, closed form"),
    tracked("pendulum_3d", 5.0, "stored truth, rigid bodies", accuracy=10.0),
    tracked("double_pendulum", 1.0, "SciPy DOP853, chains", {"rates": (0.5, -0.3)}, 1e-13, 30.0),
)
DEFAULT_STEPS = 100  # steps of an integrator that offers no settings


def contender_cases(paths: Sequence[str], limit: float, thresholds: Thresholds) -> tuple[Case, ...]:
    """A case for each integrator and problem that it supports, at its finest setting.

    Parameters
    ----------
    paths
        "package.module:Class" of each integrator
    limit
        seconds for each answer of an integrator

    Raises
    ------
    ContenderError
        For an integrator that cannot be loaded.
    CannotCompare
        If no integrator supports a problem, or one fails to answer whether it does.
    """
    cases = []
    for path in dict.fromkeys(paths):
        external = ExternalIntegrator.open(path, limit)
        try:
            for case in PROBLEMS:
                problem = problem_of(vars(case))
                setting = finest(external, problem, case.step, 1, DEFAULT_STEPS)
                if external.faults:
                    raise CannotCompare(external.faults[0])
                if setting is not None:
                    contender_case = replace(
                        case,
                        name=f"{external.name}, {problem.name}",
                        contender=path,
                        defined_at=external.defined_at,
                        setting=dict(setting),
                        slower=thresholds.slower,
                        error_tolerance=thresholds.less_accurate,
                    )
                    cases.append(contender_case)
        finally:
            external.close()
    if not cases:
        raise CannotCompare(
            f"{' and '.join(paths)} take none of the problems compared on: "
            f"{', '.join(case.name for case in PROBLEMS)}."
        )
    return tuple(cases)
