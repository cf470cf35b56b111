"""Common parts of the work-precision problems of planar chains of links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    ANGLE,
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
from references.heyoka.chain import HEYOKA_CHAIN
from references.mujoco.steps import DEFAULT_STEP, MUJOCO_EULER, MUJOCO_IMPLICIT, MUJOCO_RK4
from references.scipy.chain_ivp import CHAIN_DOP853
from references.stored.chain import STORED_CHAIN

DURATION = 5.0  # some ten Lyapunov times of the double pendulum: tests/references
RK4_STEPS = (500, 2000, round(DURATION / DEFAULT_STEP), 8000, 16_000)
FIRST_ORDER_STEPS = (2000, 8000)


def chain(
    problem: Problem, quick: bool, ours: Mapping[int, Sequence[int]], tolerances: Sequence[float]
) -> WorkPrecisionProblem:
    """All contenders on one chain; a few settings of each when quick.

    ours        degree: numbers of galvi's steps
    tolerances  of heyoka, not in compact mode, which compiles for seconds and runs faster

    MuJoCo's discrete and implicitfast equal its Euler without damping, so they are omitted.
    """

    def truth() -> Truth:
        kept = STORED_CHAIN.run(problem, DURATION, {"samples": 1})
        error = 0.5 * EPS * float(np.max(np.abs(kept.q[-1])))
        return Truth(kept.q[-1], error, f"{kept.method}; to the rounding of the angles")

    def steps(*counts: int) -> list[Setting]:
        return [fixed(DURATION, count) for count in (counts[1:2] if quick else counts)]

    def at(*values: float) -> list[Setting]:
        return adaptive("tolerance", values[1:2] if quick else values)

    participants: list[Participant] = [
        Participant(
            f"galvi degree {degree}, Gauss {degree}",
            gauss_collocation(degree),
            steps(*counts) if quick else stopped_early_too(steps(*counts)),
        )
        for degree, counts in ours.items()
    ]
    participants += [
        Participant(MUJOCO_RK4.name, MUJOCO_RK4, steps(*RK4_STEPS)),
        *(
            Participant(one.name, one, steps(*FIRST_ORDER_STEPS))
            for one in (MUJOCO_EULER, MUJOCO_IMPLICIT)
        ),
        Participant(CHAIN_DOP853.name, CHAIN_DOP853, at(1e-6, 1e-9, 1e-11)),
        Participant(HEYOKA_CHAIN.name, HEYOKA_CHAIN, at(*tolerances)),
    ]
    return WorkPrecisionProblem(
        problem,
        DURATION,
        tuple(participants),
        truth,
        quantity=ANGLE,
        distance=largest_difference,
        net_time=True,
    )
