"""Work-precision on a chain of five rods."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.chains import chain

STEPS = {4: (100, 140, 200), 6: (50, 70, 100, 140, 200), 8: (50, 70, 100, 140)}
TOLERANCES = (1e-4, 1e-5, 1e-7, 1e-9, 1e-10, 1e-11)  # compiled in 10 s together


def planar_chain(quick: bool) -> WorkPrecisionProblem:
    """Five rods, released straight from an angle of one radian."""
    return chain(galvi.problems.planar_chain(), quick, STEPS, TOLERANCES)
