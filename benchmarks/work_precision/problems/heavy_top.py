"""Work-precision on the heavy symmetric top."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import rigid_body, stored_truth

STEPS = {4: (160,), 6: (80, 120, 160), 8: (80, 120, 160), 12: (80, 120)}


def heavy_top(quick: bool) -> WorkPrecisionProblem:
    """A fast top on its tip, some twenty-five turns about its axis."""
    problem = galvi.problems.heavy_top()
    return rigid_body(problem, quick, STEPS, stored_truth(problem), brief=True)
