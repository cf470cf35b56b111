"""Work-precision on the 3D pendulum."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import EPS, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import DURATION, rigid_body
from references.stored.attitude import STORED_ATTITUDE

STEPS = {
    4: (20, 40, 80, 160),
    6: (20, 30, 40),
    8: (20, 30, 40),
    10: (20, 30),
    12: (20, 30),
}


def pendulum(quick: bool) -> WorkPrecisionProblem:
    """H's 3D pendulum, from near its equilibrium."""
    problem = galvi.problems.pendulum_3d()

    def truth() -> Truth:
        kept = STORED_ATTITUDE.run(problem, DURATION, {"samples": 1})
        return Truth(kept.q[-1], 0.5 * EPS, f"{kept.method}; to the rounding of the entries")

    return rigid_body(problem, quick, STEPS, truth)
