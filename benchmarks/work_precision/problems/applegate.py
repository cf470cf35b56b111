"""Work-precision on Applegate's outer planets."""

from __future__ import annotations

from dataclasses import replace

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.planets import planets
from references.textbook.euler import SYMPLECTIC_EULER
from references.textbook.stormer_verlet import STORMER_VERLET

FAR_BEHIND = ("2 passes", "SciPy")  # errors of 1e-2, the latter after seconds


def applegate(quick: bool) -> WorkPrecisionProblem:
    """Applegate's outer planets: 10,000 years of 365 days, or 1000 when quick.

    The contenders of `outer_solar_system`, but for those FAR_BEHIND there, at the few settings of
    its quick form: the same planets, with other masses and another start.
    """
    case = planets(
        galvi.problems.applegate(),
        1_000.0 if quick else 10_000.0,
        4332.6 / 365.0,
        True,
        (
            ("Stormer-Verlet", STORMER_VERLET, (100,), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )
    kept = [one for one in case.participants if not any(word in one.label for word in FAR_BEHIND)]
    return replace(case, participants=tuple(kept))
