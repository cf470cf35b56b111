"""Every work-precision study of the report."""

from __future__ import annotations

from benchmarks.work_precision.chains import double_pendulum, planar_chain
from benchmarks.work_precision.problem import (
    WorkPrecisionProblem,
    applegate,
    kepler,
    outer_solar_system,
    solar_system,
)
from benchmarks.work_precision.rigid_bodies import free_body, pendulum


def work_precision_problems(quick: bool) -> tuple[WorkPrecisionProblem, ...]:
    """Shorter runs and fewer settings when quick."""
    orbits = (kepler(10 if quick else 100, quick), outer_solar_system(quick), solar_system(quick))
    bodies = (free_body(quick), pendulum(quick), double_pendulum(quick), planar_chain(quick))
    return (*orbits, *bodies) if quick else (*orbits, applegate(quick), *bodies)
