"""Work-precision on the Kepler problem."""

from __future__ import annotations

import math

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import (
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    galvi_label,
)
from references.closed_forms.kepler import KEPLER
from references.rebound import ias15
from references.scipy.ivp import DOP853, ODE45
from references.textbook.euler import SYMPLECTIC_EULER
from references.textbook.stormer_verlet import STORMER_VERLET


def kepler(periods: int, quick: bool) -> WorkPrecisionProblem:
    """The Kepler problem, e = 0.6. WHFast is excluded: it solves this problem in closed form."""
    problem, duration = galvi.problems.kepler(0.6), periods * math.tau

    def truth() -> Truth:
        end = KEPLER.run(problem, duration, {"samples": 1}).q[-1]
        error = 4.0 * EPS * duration * 2.0
        return Truth(end, error, KEPLER.name)

    def steps(*per_period: int) -> list[Setting]:
        # Never a whole number of steps a period: errors that resonate with it say little.
        return [fixed(duration, k * periods + periods // 3 + 1) for k in per_period]

    tolerances = (1e-6, 1e-9) if quick else (1e-6, 1e-9, 1e-12)
    return WorkPrecisionProblem(
        problem,
        duration,
        (
            *(
                Participant(galvi_label(s), gauss_collocation(s), steps(*counts))
                for s, counts in {
                    2: (64, 256, 1024, 4096),
                    4: (16, 32, 64, 128, 256),
                    8: (6, 12, 24, 48),
                    16: (4, 8, 12),
                }.items()
            ),
            Participant(
                "REBOUND IAS15",
                ias15.IAS15,
                [*adaptive("epsilon", (1e-4, 1e-9)), {"samples": 1, **ias15.GLOBAL}],
            ),
            Participant("SciPy DOP853", DOP853, adaptive("tolerance", tolerances)),
            Participant("SciPy RK45 (ode45)", ODE45, adaptive("tolerance", tolerances[:2])),
            Participant("Stormer-Verlet", STORMER_VERLET, steps(100, 1000, 10_000)),
            Participant("symplectic Euler", SYMPLECTIC_EULER, steps(1000, 10_000)),
        ),
        truth,
    )


def kepler_orbit(quick: bool) -> WorkPrecisionProblem:
    """The Kepler problem over 100 periods, or 10 when quick."""
    return kepler(10 if quick else 100, quick)
