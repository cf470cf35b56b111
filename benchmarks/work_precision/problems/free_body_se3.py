"""Work-precision on a free body that rotates and translates."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
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
)
from references.closed_forms.thrown_body import THROWN_BODY
from references.heyoka.rigid import HEYOKA_RIGID
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_EULER, MUJOCO_RK4

DURATION = 20.0
STEPS = {4: (60, 120), 5: (40, 60, 120), 6: (40, 60), 8: (30, 40, 60), 12: (30, 40)}
GENERAL = 5  # degree of the row by the general kernel


def free_body_se3(quick: bool) -> WorkPrecisionProblem:
    """H's free rigid body, thrown, over about nine turns.

    In a longer run its place grows, and with it the error that a tolerance allows.
    """
    problem = galvi.problems.free_body_se3()

    def truth() -> Truth:
        end = THROWN_BODY.run(problem, DURATION, {"samples": 1}).q[-1]
        error = 0.5 * EPS * float(np.max(np.abs(end)))
        return Truth(end, error, f"{THROWN_BODY.name}; to the rounding of the entries")

    def steps(*counts: int) -> list[Setting]:
        return [fixed(DURATION, count) for count in (counts[1:2] if quick else counts)]

    participants = [
        Participant(galvi_label(degree), gauss_collocation(degree), steps(*counts))
        for degree, counts in STEPS.items()
    ]
    participants.append(
        Participant(
            f"{galvi_label(GENERAL)}, general kernel",
            gauss_collocation(GENERAL),
            [{**one, "solver": "newton"} for one in steps(*STEPS[GENERAL])],
        )
    )
    participants += [
        Participant(
            MUJOCO_RK4.name, MUJOCO_RK4,
            steps(100, 400, 1600, 6400, round(DURATION / DEFAULT_STEP)),
        ),
        Participant(MUJOCO_EULER.name, MUJOCO_EULER, steps(1000, 6000)),
        Participant(
            HEYOKA_RIGID.name, HEYOKA_RIGID,
            adaptive("tolerance", (1e-9,) if quick else (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)),
        ),
    ]  # fmt: skip
    return WorkPrecisionProblem(
        problem,
        DURATION,
        tuple(participants),
        truth,
        quantity=MOTION,
        distance=largest_difference,
        net_time=True,
    )
