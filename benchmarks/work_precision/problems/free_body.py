"""Work-precision on the free rigid body."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import EPS, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import DURATION, rigid_body
from references.closed_forms.free_top import FREE_TOP

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
