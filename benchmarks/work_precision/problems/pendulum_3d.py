"""Work-precision on the 3D pendulum."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import rigid_body, stored_truth

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
    return rigid_body(problem, quick, STEPS, stored_truth(problem))
