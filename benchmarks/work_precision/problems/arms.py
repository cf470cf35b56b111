"""Work-precision on robots' arms with skew hinges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import readable_setting
from benchmarks.work_precision.problem import (
    COORDINATES,
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
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS
from references.mujoco.steps import (
    DEFAULT_STEP,
    MUJOCO_DISCRETE,
    MUJOCO_EULER,
    MUJOCO_IMPLICIT,
    MUJOCO_IMPLICITFAST,
    MUJOCO_RK4,
)

TIGHT, SECOND = 1e-13, 1e-12  # tolerances of the truth, and of what its error is taken from
RK4_STEPS, FIRST_ORDER_STEPS = (200, 800, 3200, 12_800), (2000, 16_000)
FIRST_ORDER = (MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_IMPLICITFAST, MUJOCO_DISCRETE)


def skew_arm(quick: bool) -> WorkPrecisionProblem:
    """Three links on skew hinges that swing in gravity for some two turns."""
    steps = {4: (100, 200, 400), 6: (80, 100, 140), 8: (50, 70, 100)}
    return _arm(galvi.problems.skew_arm(), 2.0, quick, steps, COORDINATES)


def floating_arm(quick: bool) -> WorkPrecisionProblem:
    """The same arm on a body that floats without weight."""
    steps = {4: (50, 100, 200, 400), 6: (50, 70, 100), 8: (40, 50, 70)}
    return _arm(galvi.problems.skew_arm(floating=True), 10.0, quick, steps, MOTION)


def _arm(
    problem: Problem, duration: float, quick: bool, ours: Mapping[int, Sequence[int]], quantity: str
) -> WorkPrecisionProblem:
    """galvi, MuJoCo's integrators, and DOP853 on MuJoCo's accelerations, which is the truth.

    ours  degree: numbers of steps
    """

    def truth() -> Truth:
        end, coarser = (
            MUJOCO_ACCELERATIONS.run(problem, duration, {"samples": 1, "tolerance": one}).q[-1]
            for one in (TIGHT, SECOND)
        )
        name = MUJOCO_ACCELERATIONS.name
        description = f"{name}, tolerance {TIGHT:g}; by its difference from {SECOND:g}"
        (run,) = adaptive("tolerance", (TIGHT,))
        source = (name, readable_setting(run))
        return Truth(end, largest_difference(end, coarser), description, source)

    def steps(counts: Sequence[int]) -> list[Setting]:
        return [fixed(duration, count) for count in (counts[1:2] if quick else counts)]

    participants = [
        Participant(
            galvi_label(degree),
            gauss_collocation(degree),
            steps(counts) if quick else stopped_early_too(steps(counts)),
        )
        for degree, counts in ours.items()
    ]
    rk4 = steps((*RK4_STEPS, round(duration / DEFAULT_STEP)))
    participants.append(Participant(MUJOCO_RK4.name, MUJOCO_RK4, rk4))
    participants += [Participant(one.name, one, steps(FIRST_ORDER_STEPS)) for one in FIRST_ORDER]
    participants.append(
        Participant(
            MUJOCO_ACCELERATIONS.name,
            MUJOCO_ACCELERATIONS,
            adaptive("tolerance", (1e-9,) if quick else (1e-6, 1e-9, 1e-11, TIGHT)),
        )
    )
    return WorkPrecisionProblem(
        problem,
        duration,
        tuple(participants),
        truth,
        quantity=quantity,
        distance=largest_difference,
        net_time=True,
    )
