"""Work-precision on a grain of sand in a rotor's wind."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    COORDINATES,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
    largest_difference,
)
from references.scipy.ivp import DOP853, ODE45, TIGHT

DURATION = 2.0  # half of its fall
STEPS = {2: (50, 100, 200), 4: (50, 100, 200), 6: (50, 100)}
GENERAL = 4  # degree of the row by the general kernel
ACCURACY = 2e-14  # m; from truths with tolerances 3, 10 and 30 times looser


def brownout(quick: bool) -> WorkPrecisionProblem:
    """A grain of 100 micrometres."""
    problem = galvi.problems.brownout()

    def truth() -> Truth:
        run = DOP853.run(problem, DURATION, {"samples": 1, **TIGHT})
        return Truth(run.q[-1], ACCURACY, f"{DOP853.name} at rtol={TIGHT['rtol']:g}")

    def steps(*counts: int) -> list[Setting]:
        return [fixed(DURATION, count) for count in (counts[1:2] if quick else counts)]

    participants = [
        Participant(galvi_label(degree), gauss_collocation(degree), steps(*counts))
        for degree, counts in STEPS.items()
    ]
    participants += [
        Participant(
            f"{galvi_label(GENERAL)}, general kernel",
            gauss_collocation(GENERAL),
            [{**one, "solver": "newton"} for one in steps(*STEPS[GENERAL])],
        ),
        *(
            Participant(one.name, one, adaptive("tolerance", (1e-6,) if quick else (1e-6, 1e-9)))
            for one in (DOP853, ODE45)
        ),
    ]
    return WorkPrecisionProblem(
        problem,
        DURATION,
        tuple(participants),
        truth,
        quantity=COORDINATES,
        distance=largest_difference,
        net_time=True,
    )
