"""Work-precision on the double pendulum."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.chains import chain

STEPS = {4: (100, 200, 400), 8: (50, 100, 200), 12: (40, 60, 100)}


def double_pendulum(quick: bool) -> WorkPrecisionProblem:
    """Two point masses on massless rods, from a chaotic start."""
    return chain(galvi.problems.double_pendulum(), quick, STEPS)
