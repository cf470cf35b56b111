"""Work-precision on the double pendulum."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.chains import chain

STEPS = {4: (200, 280, 400), 6: (140, 200), 8: (80, 100, 140, 200, 280), 12: (80, 100, 140)}
TOLERANCES = (1e-6, 1e-7, 1e-9, 1e-11, 1e-13, 2.0**-52)


def double_pendulum(quick: bool) -> WorkPrecisionProblem:
    """Two point masses on massless rods, from a chaotic start."""
    return chain(galvi.problems.double_pendulum(), quick, STEPS, TOLERANCES)
