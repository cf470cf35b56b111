"""Work-precision on a chain of five rods."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.chains import chain

STEPS = {4: (100, 200, 400), 6: (60, 100, 150), 8: (60, 80, 100)}


def planar_chain(quick: bool) -> WorkPrecisionProblem:
    """Five rods, released straight from an angle of one radian."""
    return chain(galvi.problems.planar_chain(), quick, STEPS)
