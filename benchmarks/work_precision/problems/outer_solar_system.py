"""Work-precision on the outer solar system."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.planets import planets
from references.textbook.euler import SYMPLECTIC_EULER
from references.textbook.stormer_verlet import STORMER_VERLET


def outer_solar_system(quick: bool) -> WorkPrecisionProblem:
    """Sun with the inner planets, Jupiter to Pluto: 10,000 years, or 1000 when quick."""
    return planets(
        galvi.problems.outer_solar_system(),
        365_250.0 if quick else 3_652_500.0,
        4332.6,
        quick,
        (
            ("Stormer-Verlet", STORMER_VERLET, (100, 300), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )
