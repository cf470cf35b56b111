"""Rigid bodies, on a pivot, free, and on SE(3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from benchmarks.work_precision.problem import (
    ATTITUDE,
    EPS,
    MOTION,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
    largest_difference,
    stopped_early_too,
)
from galvi import Problem
from galvi.charts import CHARTS
from references.closed_forms.thrown_body import THROWN_BODY
from references.closed_forms.top_motion import FREE_TOP
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
from references.textbook.quaternion_dop853 import QUATERNION_DOP853
from references.textbook.quaternion_rk4 import QUATERNION_RK4

DURATION = 20.0
MUJOCO = (MUJOCO_EULER, MUJOCO_RK4, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)
TEXTBOOK_RK4, TEXTBOOK_DOP853 = QUATERNION_RK4.name, QUATERNION_DOP853.name
# MuJoCo's and the textbook's, to compare their steps, one of which is MuJoCo's default.
RK4_STEPS = (100, 400, 1600, 6400, round(DURATION / DEFAULT_STEP), 25_600)
FIRST_ORDER_STEPS = (1000, 6000, 36_000)
EARLY = 8  # greatest degree whose iterations are stopped early too


def stored_truth(problem: Problem) -> Callable[[], Truth]:
    """The stored motion of a body in weight."""

    def truth() -> Truth:
        kept = STORED_ATTITUDE.run(problem, DURATION, {"samples": 1})
        return Truth(kept.q[-1], 0.5 * EPS, f"{kept.method}; to the rounding of the entries")

    return truth


def rigid_body(
    problem: Problem,
    quick: bool,
    ours: Mapping[int, Sequence[int]],
    truth: Callable[[], Truth],
    more_points: Mapping[int, Sequence[int]] | None = None,
    brief: bool = False,
    longer: Mapping[int, Sequence[int]] | None = None,
) -> WorkPrecisionProblem:
    """Everyone on one body; a few settings of each when quick.

    ours         degree: numbers of galvi's steps, with as many Gauss points as the degree
    more_points  the same with one point more, H's n points for n functions, in Cayley's chart
    longer       more numbers of steps, fewer, for the chart of modified Rodrigues parameters alone
    brief        Cayley's chart, MuJoCo's RK4, the compiled DOP853 and heyoka alone
    """

    def steps(*counts: int) -> list[Setting]:
        chosen = (counts[1:4:2] or counts) if quick else counts
        return [fixed(DURATION, count) for count in chosen]

    def our_steps(*counts: int) -> list[Setting]:
        return steps(*counts) if quick else stopped_early_too(steps(*counts))

    def tolerances(*values: float) -> list[Setting]:
        return adaptive("tolerance", values[1:3] if quick else values)

    def counts_of(chart: Any, degree: int) -> Sequence[int]:
        reaches = isinstance(chart, galvi.ModifiedRodrigues)
        return (*((longer or {}).get(degree, ()) if reaches else ()), *ours[degree])

    participants: list[Participant] = [
        Participant(
            f"galvi degree {degree}, Gauss {degree}, {chart.name}",
            gauss_collocation(degree, chart),
            (our_steps if degree <= EARLY and not isinstance(chart, galvi.Exponential) else steps)(
                *counts_of(chart, degree)
            ),
        )
        for chart in (CHARTS[:1] if brief else CHARTS)
        for degree in ours
    ]
    participants += [
        Participant(
            f"galvi degree {degree}, Gauss {degree + 1}, Cayley",
            Variational(galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + 1))),
            (our_steps if degree <= EARLY else steps)(*counts),
        )
        for degree, counts in (more_points or {}).items()
    ]
    for engine in (MUJOCO_RK4,) if brief else MUJOCO:
        counts = RK4_STEPS if engine is MUJOCO_RK4 else FIRST_ORDER_STEPS
        participants.append(Participant(engine.name, engine, steps(*counts)))
    participants += [
        Participant(
            TEXTBOOK_DOP853, QUATERNION_DOP853, tolerances(1e-5, 1e-8, 1e-11, 1e-13, 1e-15)
        ),
        Participant(HEYOKA_RIGID.name, HEYOKA_RIGID, tolerances(1e-5, 1e-7, 1e-9, 1e-11, 1e-13)),
    ]
    if not brief:
        participants += [
            Participant(TEXTBOOK_RK4, QUATERNION_RK4, steps(*RK4_STEPS)),
            Participant(RIGID_DOP853.name, RIGID_DOP853, tolerances(1e-6, 1e-9, 1e-12)),
        ]
    return WorkPrecisionProblem(
        problem,
        DURATION,
        tuple(participants),
        truth,
        quantity=ATTITUDE,
        distance=largest_difference,
        repeated_run=True,
    )


STEPS = {
    4: (60, 120),
    6: (40, 60, 120),
    7: (30, 40, 60),
    8: (30, 40, 60),
    10: (30, 40),
    12: (30, 40),
}
LONGER = {8: (20, 24)}
MORE_POINTS = {6: (40, 60), 7: (30, 40, 60), 8: (30, 40, 60), 10: (30, 40)}


def free_body(quick: bool) -> WorkPrecisionProblem:
    """H's free rigid body over about nine turns."""
    problem = galvi.problems.free_rigid_body()

    def truth() -> Truth:
        end = FREE_TOP.run(problem, DURATION, {"samples": 1}).q[-1]
        return Truth(end, 0.5 * EPS, f"{FREE_TOP.name}; to the rounding of the entries")

    return rigid_body(problem, quick, STEPS, truth, MORE_POINTS, longer=LONGER)


PENDULUM_STEPS = {
    4: (20, 40, 80, 160),
    6: (20, 30, 40),
    8: (20, 30, 40),
    10: (20, 30),
    12: (20, 30),
}


def pendulum(quick: bool) -> WorkPrecisionProblem:
    """H's 3D pendulum, from near its equilibrium."""
    problem = galvi.problems.pendulum_3d()
    return rigid_body(problem, quick, PENDULUM_STEPS, stored_truth(problem))


TOP_STEPS = {4: (160,), 6: (80, 120, 160), 8: (80, 120, 160), 12: (80, 120)}


def heavy_top(quick: bool) -> WorkPrecisionProblem:
    """A fast top on its tip, some twenty-five turns about its axis."""
    problem = galvi.problems.heavy_top()
    return rigid_body(problem, quick, TOP_STEPS, stored_truth(problem), brief=True)


MOVING_DURATION = 20.0
MOVING_STEPS = {4: (60, 120), 5: (40, 60, 120), 6: (40, 60), 8: (30, 40, 60), 12: (30, 40)}
GENERAL = 5  # degree of the row by the general kernel


def free_body_se3(quick: bool) -> WorkPrecisionProblem:
    """H's free rigid body, thrown, over about nine turns.

    In a longer run its place grows, and with it the error that a tolerance allows.
    """
    problem = galvi.problems.free_body_se3()

    def truth() -> Truth:
        end = THROWN_BODY.run(problem, MOVING_DURATION, {"samples": 1}).q[-1]
        error = 0.5 * EPS * float(np.max(np.abs(end)))
        return Truth(end, error, f"{THROWN_BODY.name}; to the rounding of the entries")

    def steps(*counts: int) -> list[Setting]:
        return [fixed(MOVING_DURATION, count) for count in (counts[1:2] if quick else counts)]

    participants = [
        Participant(galvi_label(degree), gauss_collocation(degree), steps(*counts))
        for degree, counts in MOVING_STEPS.items()
    ]
    participants.append(
        Participant(
            f"{galvi_label(GENERAL)}, general kernel",
            gauss_collocation(GENERAL),
            [{**one, "solver": "newton"} for one in steps(*MOVING_STEPS[GENERAL])],
        )
    )
    participants += [
        Participant(
            MUJOCO_RK4.name, MUJOCO_RK4,
            steps(100, 400, 1600, 6400, round(MOVING_DURATION / DEFAULT_STEP)),
        ),
        Participant(MUJOCO_EULER.name, MUJOCO_EULER, steps(1000, 6000)),
        Participant(
            HEYOKA_RIGID.name, HEYOKA_RIGID,
            adaptive("tolerance", (1e-9,) if quick else (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)),
        ),
    ]  # fmt: skip
    return WorkPrecisionProblem(
        problem,
        MOVING_DURATION,
        tuple(participants),
        truth,
        quantity=MOTION,
        distance=largest_difference,
        net_time=True,
    )
