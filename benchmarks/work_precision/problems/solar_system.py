"""Work-precision on the Sun and eight planets."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.planets import WISDOM, planets
from references.rebound import whfast512
from references.textbook.euler import SYMPLECTIC_EULER
from references.textbook.stormer_verlet import STORMER_VERLET


def solar_system(quick: bool) -> WorkPrecisionProblem:
    """Sun and 8 planets: 200 years, or 20 when quick."""
    return planets(
        galvi.problems.solar_system(pluto=False),
        7_305.0 if quick else 73_050.0,
        87.97,
        quick,
        (
            ("REBOUND WHFast512", whfast512.WHFAST512, WISDOM, whfast512.BEST),
            ("Stormer-Verlet", STORMER_VERLET, (100, 300), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )
