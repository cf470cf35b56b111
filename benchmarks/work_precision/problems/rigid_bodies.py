"""What work-precision problems of rigid bodies share: galvi, MuJoCo and textbook methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import galvi
from benchmarks.work_precision.galvi_methods import Variational, gauss_collocation
from benchmarks.work_precision.problem import (
    ATTITUDE,
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    largest_difference,
    stopped_early_too,
)
from galvi import Problem
from galvi.charts import CHARTS
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
