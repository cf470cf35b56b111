"""Work-precision problems: what is solved, how long, by whom with which settings, the truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi import Problem
from galvi.arrays import Array
from references import Contender
from references.closed_forms.kepler import KEPLER
from references.heyoka import taylor as heyoka_taylor
from references.rebound import ias15, saba, whfast, whfast512
from references.scipy.ivp import DOP853, ODE45
from references.stored.planets import STORED_TRUTH
from references.textbook.euler import SYMPLECTIC_EULER
from references.textbook.stormer_verlet import STORMER_VERLET

Setting = Mapping[str, Any]
POSITION, ATTITUDE, ANGLE = "position", "attitude", "angle"
EPS = float(np.finfo(float).eps)
# Steps a period, and a third, for Wisdom and Holman's maps: to where rounding stops WHFast on the
# outer planets (10,000 years: 4.5e-9 with 120, 1.5e-9 with 240, 4.0e-9 with 480).
WISDOM = (10, 15, 20, 30, 60, 120, 240)


class Participant(NamedTuple):
    """A contender with its label and the settings that it is run with."""

    label: str
    contender: Contender
    settings: Sequence[Setting]


@dataclass(frozen=True, eq=False)
class Truth:
    """The true configuration at the end.

    end          (...,) in the configuration's shape
    error        of it, as `WorkPrecisionProblem.distance` measures errors
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


def farthest_body(q: Array, truth: Array) -> float:
    """Largest distance of a body from where it should be, in the problem's unit of length."""
    return float(np.max(np.linalg.norm(q - truth, axis=-1)))


@dataclass(frozen=True, eq=False)
class WorkPrecisionProblem:
    """One work-precision study.

    problem       what is solved
    duration      from its t0, in its unit of time
    participants  who solves it
    truth         computes the truth
    quantity      whose error it is: POSITION, ATTITUDE or ANGLE
    distance      of two configurations: the error
    repeated_run  whether runs are timed by going on, as `benchmarks.statistics.repeated_run` does:
                  for durations that a contender covers before its call has properly begun
    """

    problem: Problem
    duration: float
    participants: tuple[Participant, ...]
    truth: Callable[[], Truth]
    quantity: str = POSITION
    distance: Callable[[Array, Array], float] = farthest_body
    repeated_run: bool = False


def kepler(periods: int, quick: bool) -> WorkPrecisionProblem:
    """Eccentricity 0.6. WHFast has no place here: it solves this problem in closed form."""
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
                Participant(_ours(s), gauss_collocation(s), steps(*counts))
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


def outer_solar_system(quick: bool) -> WorkPrecisionProblem:
    """Sun with the inner planets, Jupiter to Pluto: 10,000 years, or 1000 when quick."""
    return _planets(
        galvi.problems.outer_solar_system(),
        365_250.0 if quick else 3_652_500.0,
        4332.6,
        quick,
        (
            ("Stormer-Verlet", STORMER_VERLET, (100, 300), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )


def solar_system(quick: bool) -> WorkPrecisionProblem:
    """Sun and 8 planets: 200 years, or 20 when quick."""
    return _planets(
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


def applegate(quick: bool) -> WorkPrecisionProblem:
    """Applegate's outer planets: 10,000 years of 365 days, or 1000 when quick.

    Every contender of `outer_solar_system`, on the few settings of its quick form: the planets are
    the same, from other masses and another start.
    """
    return _planets(
        galvi.problems.applegate(),
        1_000.0 if quick else 10_000.0,
        4332.6 / 365.0,
        True,
        (
            ("Stormer-Verlet", STORMER_VERLET, (100,), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )


def _planets(
    problem: Problem, duration: float, period: float, few: bool, others: Sequence[Any]
) -> WorkPrecisionProblem:
    """galvi, REBOUND, heyoka and SciPy on planets; the truth is the stored one.

    duration  on which the truth is kept, in the problem's unit of time
    period    of the fastest planet, likewise, to which numbers of steps refer
    few       fewer settings of the references, their defaults and their best among them
    others    (label, contender, steps a period, options), for this problem only
    """

    def truth() -> Truth:
        kept = STORED_TRUTH.run(problem, duration, {"samples": 1})
        speed = np.max(np.abs(problem.system.velocity(kept.p[-1])))
        error = EPS * (float(np.max(np.abs(kept.q[-1]))) + duration * float(speed))
        text = f"{kept.method}; to the rounding of positions and times, {error:.0e} au"
        return Truth(kept.q[-1], error, text)

    def steps(*per_period: float, **options: Any) -> list[Setting]:
        # Never a whole number of steps a period: errors that resonate with it say little.
        counts = [round(duration * (k + 1.0 / 3.0) / period) for k in per_period]
        return [{**fixed(duration, count), **options} for count in counts]

    def once(**options: Any) -> Setting:
        return {"samples": 1, **options}

    best = [
        {**one, "kernel": kernel}
        for kernel in (("LAZY",) if few else ("LAZY", "DEFAULT"))
        for one in steps(*WISDOM, **whfast.BEST)
    ]
    looser = [
        {**mode, "epsilon": epsilon}
        for mode in (ias15.DEFAULT, ias15.GLOBAL)
        for epsilon in ((1e-5,) if few else (1e-7, 1e-5, 1e-3))
    ]
    taylor = [heyoka_taylor.DEFAULT, heyoka_taylor.BEST]
    taylor += [] if few else [{**heyoka_taylor.DEFAULT, "tolerance": 1e-12}]
    return WorkPrecisionProblem(
        problem,
        duration,
        (
            *(
                Participant(_ours(s), gauss_collocation(s), steps(*per_period))
                for s, per_period in {
                    6: (6, 8, 12, 16, 20, 24),
                    8: (4, 6, 8, 10, 12, 16),
                    12: (2, 3, 4, 5, 6, 8),
                    16: (1.5, 2, 2.5, 3, 4),
                }.items()
            ),
            Participant("REBOUND IAS15", ias15.IAS15, [once(**ias15.DEFAULT)]),
            Participant("REBOUND IAS15, GLOBAL", ias15.IAS15, [once(**ias15.GLOBAL)]),
            Participant(
                "REBOUND IAS15, looser", ias15.IAS15, [once(**options) for options in looser]
            ),
            Participant("REBOUND WHFast, best", whfast.WHFAST, best),
            Participant("REBOUND WHFast, default", whfast.WHFAST, steps(30, 120, **whfast.DEFAULT)),
            Participant("REBOUND SABA(10,6,4)", saba.SABA, steps(3, 5, 7, 10, 20, **saba.BEST)),
            Participant("heyoka", heyoka_taylor.HEYOKA, [once(**options) for options in taylor]),
            Participant(
                "SciPy DOP853", DOP853, adaptive("tolerance", (1e-9,) if few else (1e-9, 1e-12))
            ),
            *(
                Participant(label, contender, steps(*k, **more))
                for label, contender, k, more in others
            ),
        ),
        truth,
    )


def _ours(stages: int) -> str:
    return f"galvi degree {stages}, Gauss {stages}"


def fixed(duration: float, steps: int) -> Setting:
    """So many equal steps, of which the last state is kept."""
    return {"step": duration / steps, "save_every": steps}


def adaptive(key: str, values: Sequence[float]) -> list[Setting]:
    """One setting for each value of this key; the last state is kept."""
    return [{"samples": 1, key: value} for value in values]
