"""Where contenders meet: a problem, how long, who takes part with which settings, and the truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from benchmarks.contenders import gauss_collocation
from galvi import Problem
from galvi.arrays import Array
from references import Contender, ias15, whfast
from references.euler import SYMPLECTIC_EULER
from references.kepler import KEPLER
from references.scipy_ivp import DOP853, ODE45
from references.stormer_verlet import STORMER_VERLET

Setting = Mapping[str, Any]
Entry = tuple[str, Contender, Sequence[Setting]]


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the bodies are at the end.

    end          (...,) in the configuration's shape
    error        of it, in the problem's unit of length
    description  for the table
    source       label of the contenders that it comes from, which are not judged by it
    """

    end: Array
    error: float
    description: str
    source: str = ""

    def is_from(self, contender: str) -> bool:
        """Whether the contender would be compared with itself."""
        return bool(self.source) and contender.startswith(self.source)


@dataclass(frozen=True, eq=False)
class Arena:
    """One work-precision study.

    problem   what is solved
    duration  from its t0, in its unit of time
    entries   (label, contender, settings)
    truth     computes the truth
    """

    problem: Problem
    duration: float
    entries: tuple[Entry, ...]
    truth: Callable[[], Truth]


def arenas(quick: bool) -> tuple[Arena, ...]:
    """The studies of the report: shorter runs and fewer settings when quick."""
    return kepler(10 if quick else 100, quick), solar_system(10 if quick else 100, quick)


def kepler(periods: int, quick: bool) -> Arena:
    """Eccentricity 0.6. WHFast has no place here: it solves this problem in closed form."""
    problem, duration = galvi.problems.kepler(0.6), periods * math.tau

    def truth() -> Truth:
        end = KEPLER.run(problem, duration, {"samples": 1}).q[-1]
        error = 4.0 * float(np.finfo(float).eps) * duration * 2.0
        return Truth(end, error, KEPLER.name)

    def steps(*per_period: int) -> list[Setting]:
        # Never a whole number of steps a period: errors that resonate with it say little.
        return [_fixed(duration, k * periods + periods // 3 + 1) for k in per_period]

    tolerances = (1e-6, 1e-9) if quick else (1e-6, 1e-9, 1e-12)
    return Arena(
        problem,
        duration,
        (
            *(
                (_ours(s), gauss_collocation(s), steps(*counts))
                for s, counts in {
                    2: (64, 256, 1024, 4096),
                    4: (16, 32, 64, 128, 256),
                    8: (6, 12, 24, 48),
                    16: (4, 8, 12),
                }.items()
            ),
            (
                "REBOUND IAS15",
                ias15.IAS15,
                [*_adaptive("epsilon", (1e-4, 1e-9)), {"samples": 1, **ias15.GLOBAL}],
            ),
            ("SciPy DOP853", DOP853, _adaptive("tolerance", tolerances)),
            ("SciPy RK45 (ode45)", ODE45, _adaptive("tolerance", tolerances[:2])),
            ("Stormer-Verlet", STORMER_VERLET, steps(100, 1000, 10_000)),
            ("symplectic Euler", SYMPLECTIC_EULER, steps(1000, 10_000)),
        ),
        truth,
    )


def solar_system(years: int, quick: bool) -> Arena:
    """Sun, 8 planets and Pluto. The truth is IAS15, checked against its other step criterion."""
    problem, duration = galvi.problems.solar_system(), 365.25 * years

    def truth() -> Truth:
        runs = [
            ias15.IAS15.run(problem, duration, {"samples": 1, **options})
            for options in (ias15.DEFAULT, ias15.GLOBAL)
        ]
        gap = float(np.max(np.linalg.norm(runs[0].q[-1] - runs[1].q[-1], axis=-1)))
        text = f"REBOUND IAS15 (PRS23), from which GLOBAL is {gap:.0e} au away"
        return Truth(runs[0].q[-1], gap, text, source="REBOUND IAS15")

    def steps(*days: float, **options: Any) -> list[Setting]:
        return [{**_fixed(duration, round(duration / h)), **options} for h in days]

    tolerances = (1e-6, 1e-9) if quick else (1e-6, 1e-9, 1e-12)
    return Arena(
        problem,
        duration,
        (
            *(
                (_ours(s), gauss_collocation(s), steps(*days))
                for s, days in {
                    4: (16.0, 8.0, 4.0, 2.0, 1.0),
                    8: (32.0, 22.0, 16.0, 11.0, 8.0),
                    16: (64.0, 48.0, 32.0, 24.0, 16.0),
                }.items()
            ),
            (
                "REBOUND IAS15",
                ias15.IAS15,
                [{"samples": 1, **ias15.DEFAULT}, {"samples": 1, **ias15.GLOBAL}],
            ),
            ("REBOUND WHFast, best", whfast.WHFAST, steps(8.0, 6.0, 4.0, 2.0, **whfast.BEST)),
            ("REBOUND WHFast, default", whfast.WHFAST, steps(8.0, 2.0, 0.5, **whfast.DEFAULT)),
            ("SciPy DOP853", DOP853, _adaptive("tolerance", tolerances)),
            ("SciPy RK45 (ode45)", ODE45, _adaptive("tolerance", tolerances[:2])),
            ("Stormer-Verlet", STORMER_VERLET, steps(4.0, 1.0, 0.25)),
            ("symplectic Euler", SYMPLECTIC_EULER, steps(1.0, 0.25)),
        ),
        truth,
    )


def _ours(stages: int) -> str:
    return f"galvi degree {stages}, Gauss {stages}"


def _fixed(duration: float, steps: int) -> Setting:
    return {"step": duration / steps, "save_every": steps}


def _adaptive(key: str, values: Sequence[float]) -> list[Setting]:
    return [{"samples": 1, key: value} for value in values]
