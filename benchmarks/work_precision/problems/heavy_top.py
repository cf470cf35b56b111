"""Work-precision on the heavy symmetric top."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.rigid_bodies import rigid_body, stored_truth
from galvi.charts import Cayley

STEPS = {4: (100, 150, 250), 6: (60, 80, 120), 8: (60, 80, 100), 12: (60, 80)}


def heavy_top(quick: bool) -> WorkPrecisionProblem:
    """A fast top on its tip, some twenty-five turns about its axis."""
    problem = galvi.problems.heavy_top()
    return rigid_body(problem, quick, STEPS, stored_truth(problem), charts=(Cayley(),))
