"""The list PROBLEMS of work-precision problems."""

from __future__ import annotations

from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.applegate import applegate
from benchmarks.work_precision.problems.arms import floating_arm, skew_arm
from benchmarks.work_precision.problems.brownout import brownout
from benchmarks.work_precision.problems.double_pendulum import double_pendulum
from benchmarks.work_precision.problems.elastic_pendulum import elastic_pendulum
from benchmarks.work_precision.problems.fermi_pasta_ulam_tsingou import fermi_pasta_ulam_tsingou
from benchmarks.work_precision.problems.free_body import free_body
from benchmarks.work_precision.problems.free_body_se3 import free_body_se3
from benchmarks.work_precision.problems.heavy_top import heavy_top
from benchmarks.work_precision.problems.henon_heiles import henon_heiles
from benchmarks.work_precision.problems.kepler import kepler_orbit
from benchmarks.work_precision.problems.kepler_polar import kepler_polar
from benchmarks.work_precision.problems.outer_solar_system import outer_solar_system
from benchmarks.work_precision.problems.pendulum_3d import pendulum
from benchmarks.work_precision.problems.planar_chain import planar_chain
from benchmarks.work_precision.problems.solar_system import solar_system

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
)
NOT_IN_QUICK = (applegate,)  # the planets of outer_solar_system, with other masses and states


def work_precision_problems(quick: bool) -> tuple[WorkPrecisionProblem, ...]:
    """Every problem; shorter runs and fewer settings when quick."""
    return tuple(make(quick) for make in PROBLEMS if not (quick and make in NOT_IN_QUICK))
