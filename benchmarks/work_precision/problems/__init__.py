"""The list PROBLEMS of work-precision problems."""

from __future__ import annotations

from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.arms import brownout, floating_arm, skew_arm
from benchmarks.work_precision.problems.encounters import ENCOUNTERS, NOT_IN_QUICK
from benchmarks.work_precision.problems.pendulums import (
    double_pendulum,
    elastic_pendulum,
    fermi_pasta_ulam_tsingou,
    henon_heiles,
    planar_chain,
)
from benchmarks.work_precision.problems.planets import (
    applegate,
    kepler_orbit,
    kepler_polar,
    outer_solar_system,
    solar_system,
)
from benchmarks.work_precision.problems.rigid_bodies import (
    free_body,
    free_body_se3,
    heavy_top,
    pendulum,
)

PROBLEMS = (
    kepler_orbit,
    outer_solar_system,
    solar_system,
    applegate,
    free_body,
    pendulum,
    double_pendulum,
    planar_chain,
    heavy_top,
    free_body_se3,
    elastic_pendulum,
    henon_heiles,
    fermi_pasta_ulam_tsingou,
    kepler_polar,
    brownout,
    skew_arm,
    floating_arm,
    *ENCOUNTERS,
)
# The planets of outer_solar_system, with other masses and states; and most encounters.
NOT_IN_QUICK = (applegate, *NOT_IN_QUICK)


def work_precision_problems(quick: bool) -> tuple[WorkPrecisionProblem, ...]:
    """Every problem; shorter runs and fewer settings when quick."""
    return tuple(make(quick) for make in PROBLEMS if not (quick and make in NOT_IN_QUICK))
