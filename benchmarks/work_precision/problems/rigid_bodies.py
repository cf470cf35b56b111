"""Rigid bodies, on a pivot, free, and on SE(3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import galvi
from benchmarks.work_precision.entries import (
    MIDDLE_VALUES,
    Entry,
    compared,
    galvi_entries,
    general_kernel,
    truth_to_rounding,
)
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from benchmarks.work_precision.problem import ATTITUDE, MOTION, WorkPrecisionProblem, galvi_label
from galvi import Problem
from galvi.charts import CHARTS
from references import Contender
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.heyoka.rigid import HEYOKA_RIGID
from references.mujoco.steps import (
    DEFAULT_STEP,
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)
from references.scipy.rigid_ivp import RIGID_DOP853
from references.stored.attitude import STORED_ATTITUDE
from references.textbook.quaternions import QUATERNION_DOP853, QUATERNION_RK4

Counts = Mapping[int, Sequence[int]]  # degree: numbers of galvi's steps
DURATION = 20.0
MUJOCO_CONTENDERS = (
    MUJOCO_EULER,
    MUJOCO_RK4,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_DISCRETE,
)
TEXTBOOK_RK4, TEXTBOOK_DOP853 = QUATERNION_RK4.name, QUATERNION_DOP853.name
# MuJoCo's and the textbook's, to compare their steps, one of which is MuJoCo's default.
RK4_STEPS = (100, 400, 1600, 6400, round(DURATION / DEFAULT_STEP), 25_600)
FIRST_ORDER_STEPS = (1000, 6000, 36_000)
TOLERANCES = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # of heyoka
HIGHEST_EARLY_DEGREE = 8  # greatest degree whose iterations are stopped early too
QUICK_VALUES = slice(1, 4, 2)


def rigid_body(
    problem: Problem,
    quick: bool,
    counts: Counts,
    truth: Contender = STORED_ATTITUDE,
    more_points: Counts | None = None,
    few_contenders: bool = False,
    longer_steps: Counts | None = None,
) -> WorkPrecisionProblem:
    """All contenders on one body; a few settings of each when quick.

    Parameters
    ----------
    counts
        with as many Gauss points as the degree
    more_points
        the same with one point more, H's n points for n functions, in Cayley's chart
    longer
        further, smaller numbers of steps for the chart of modified Rodrigues parameters
    brief
        Cayley's chart, MuJoCo's RK4, the compiled DOP853 and heyoka alone
    """

    def counts_of(chart: Any, degree: int) -> Sequence[int]:
        is_rodrigues = isinstance(chart, galvi.ModifiedRodrigues)
        return (*((longer_steps or {}).get(degree, ()) if is_rodrigues else ()), *counts[degree])

    entries = [
        Entry(
            gauss_collocation(degree, chart),
            counts_of(chart, degree),
            f"{galvi_label(degree)}, {chart.name}",
            QUICK_VALUES,
            stops_early_too=degree <= HIGHEST_EARLY_DEGREE
            and not isinstance(chart, galvi.Exponential),
        )
        for chart in (CHARTS[:1] if few_contenders else CHARTS)
        for degree in counts
    ]
    entries += [
        Entry(
            Variational(galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + 1))),
            steps,
            f"galvi degree {degree}, Gauss {degree + 1}, Cayley",
            QUICK_VALUES,
            stops_early_too=degree <= HIGHEST_EARLY_DEGREE,
        )
        for degree, steps in (more_points or {}).items()
    ]
    entries += [
        *(
            Entry(
                contender,
                RK4_STEPS if contender is MUJOCO_RK4 else FIRST_ORDER_STEPS,
                quick_values=QUICK_VALUES,
            )
            for contender in ((MUJOCO_RK4,) if few_contenders else MUJOCO_CONTENDERS)
        ),
        Entry(QUATERNION_DOP853, (1e-5, 1e-8, 1e-11, 1e-13, 1e-15), quick_values=MIDDLE_VALUES),
        Entry(HEYOKA_RIGID, TOLERANCES, quick_values=MIDDLE_VALUES),
    ]
    if not few_contenders:
        entries += [
            Entry(QUATERNION_RK4, RK4_STEPS, quick_values=QUICK_VALUES),
            Entry(RIGID_DOP853, (1e-6, 1e-9, 1e-12), quick_values=MIDDLE_VALUES),
        ]
    rounded_truth = truth_to_rounding(truth, problem, DURATION, "entries", 1.0)
    fields: dict[str, Any] = {"quantity": ATTITUDE, "repeated_run": True}
    return compared(problem, DURATION, quick, entries, rounded_truth, **fields)


def free_body(quick: bool) -> WorkPrecisionProblem:
    """H's free rigid body over about nine turns."""
    counts = {4: (60, 120), 6: (40, 60, 120), **dict.fromkeys((7, 8), (30, 40, 60))}
    counts |= dict.fromkeys((10, 12), (30, 40))
    more_points = {6: (40, 60), 7: (30, 40, 60), 8: (30, 40, 60), 10: (30, 40)}
    body = galvi.problems.free_rigid_body()
    return rigid_body(body, quick, counts, FREE_TOP, more_points, longer_steps={8: (20, 24)})


def pendulum(quick: bool) -> WorkPrecisionProblem:
    """H's 3D pendulum, from near its equilibrium."""
    counts = {4: (20, 40, 80, 160), 6: (20, 30, 40), 8: (20, 30, 40), 10: (20, 30), 12: (20, 30)}
    return rigid_body(galvi.problems.pendulum_3d(), quick, counts)


def heavy_top(quick: bool) -> WorkPrecisionProblem:
    """A fast top on its tip, some twenty-five turns about its axis."""
    counts = {4: (160,), 6: (80, 120, 160), 8: (80, 120, 160), 12: (80, 120)}
    return rigid_body(galvi.problems.heavy_top(), quick, counts, few_contenders=True)


def free_body_se3(quick: bool) -> WorkPrecisionProblem:
    """H's free rigid body, thrown, over about nine turns.

    In a longer run its place grows, and with it the error that a tolerance allows.
    """
    problem = galvi.problems.free_body_se3()
    counts = {4: (60, 120), 5: (40, 60, 120), 6: (40, 60), 8: (30, 40, 60), 12: (30, 40)}
    entries = [
        *galvi_entries(counts),
        general_kernel(5, counts[5]),
        Entry(MUJOCO_RK4, RK4_STEPS[:-1]),
        Entry(MUJOCO_EULER, FIRST_ORDER_STEPS[:-1]),
        Entry(HEYOKA_RIGID, TOLERANCES, quick_values=slice(2, 3)),
    ]
    truth = truth_to_rounding(THROWN_BODY, problem, DURATION, "entries")
    return compared(problem, DURATION, quick, entries, truth, quantity=MOTION, net_time=True)
