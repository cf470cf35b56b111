"""Point masses: two bodies, and the Solar System."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.peers import PEERS
from benchmarks.work_precision.problem import (
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
    frame_label,
    galvi_label,
)
from benchmarks.work_precision.problems.pendulums import on_coordinates
from galvi import KeplerFrame, Problem
from references.closed_forms.kepler import KEPLER
from references.heyoka import taylor as heyoka_taylor
from references.rebound import ias15, native, saba, whfast, whfast512
from references.scipy.ivp import DOP853, ODE45
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853
from references.stored.planets import STORED_TRUTH
from references.textbook.euler import STORMER_VERLET, SYMPLECTIC_EULER

# Steps per period, plus a third, for Wisdom-Holman maps: up to where rounding limits WHFast on the
# outer planets (10,000 years: 4.5e-9 with 120, 1.5e-9 with 240, 4.0e-9 with 480).
WISDOM_HOLMAN_STEPS = (10, 15, 20, 30, 60, 120, 240)
# For galvi, by its stages.
INERTIAL_STEPS = {8: (4, 6, 8, 10, 12), 12: (2, 3, 4, 5, 8), 16: (1.5, 2, 2.5, 3, 4)}
# Stages and passes: with None energies do not drift; two are the fewest that are accurate, where
# planets are a thousand times lighter than their star.
FRAME_STEPS = {
    (8, 2): (0.8, 1.1, 1.7, 3.2),
    (16, 2): (0.75, 0.85, 1.5, 1.9),
    (8, None): (1.4, 3.2, 4, 6, 8),
    (16, None): (0.75, 1.2, 1.5, 1.9, 2.5, 3, 4, 5),
}


def _galvi_participants(steps: Callable[..., list[Setting]]) -> Iterator[Participant]:
    """galvi's, at rest and in the Kepler frame; steps: numbers of steps a period -> settings."""
    for s, per_period in INERTIAL_STEPS.items():
        yield Participant(galvi_label(s), gauss_collocation(s), steps(*per_period))
    for (s, passes), per_period in FRAME_STEPS.items():
        method = gauss_collocation(s, KeplerFrame(passes=passes))
        yield Participant(frame_label(s, passes), method, steps(*per_period))


def planets(
    problem: Problem, duration: float, period: float, few_settings: bool, extra: Sequence[Any]
) -> WorkPrecisionProblem:
    """galvi, REBOUND, heyoka and SciPy on planets; the truth is the stored one.

    Parameters
    ----------
    duration
        duration of the stored truth, in the problem's unit of time
    period
        period of the fastest planet, likewise, to which numbers of steps refer
    few
        fewer settings of the references, including their defaults and their best
    extra
        (label, contender, steps per period, options), for this problem only
    """

    def truth() -> Truth:
        stored = STORED_TRUTH.run(problem, duration, {"samples": 1})
        speed = np.max(np.abs(problem.system.velocity(stored.p[-1])))
        error = EPS * (float(np.max(np.abs(stored.q[-1]))) + duration * float(speed))
        text = f"{stored.method}; to the rounding of positions and times, {error:.0e} au"
        return Truth(stored.q[-1], error, text)

    def steps(*per_period: float, **options: Any) -> list[Setting]:
        # Never a whole number of steps a period: errors that resonate with it say little.
        counts = [round(duration * (k + 1.0 / 3.0) / period) for k in per_period]
        return [{**fixed(duration, count), **options} for count in counts]

    def once(**options: Any) -> Setting:
        return {"samples": 1, **options}

    def open_settings(code: str, *per_period: float) -> list[Setting]:
        named = list(PEERS[code].open.values())[: 1 if few_settings else None]
        return [setting for options in named for setting in steps(*per_period, **options)]

    looser = [
        {**mode, "epsilon": epsilon}
        for mode, fine in ((ias15.DEFAULT, 1e-3), (ias15.GLOBAL, 1e-7))
        for epsilon in ((1e-5,) if few_settings else (1e-5, fine))
    ]
    taylor = [heyoka_taylor.DOUBLE, heyoka_taylor.BEST]
    tolerances = () if few_settings else (1e-6, 1e-9, 1e-12)
    taylor += [{**heyoka_taylor.DOUBLE, "tolerance": tolerance} for tolerance in tolerances]
    rebound_participants = [
        Participant("REBOUND IAS15", ias15.IAS15, [once(**ias15.DEFAULT)]),
        Participant(
            "REBOUND WHFast, best",
            whfast.WHFAST,
            open_settings("REBOUND WHFast", *WISDOM_HOLMAN_STEPS),
        ),
        Participant("REBOUND SABA", saba.SABA, open_settings("REBOUND SABA", 4, 7, 14)),
    ]
    native_participants: list[Participant] = []
    if not native.missing():
        native_participants = [
            Participant(f"{label}, native", native.Native(contender), settings)
            for label, contender, settings in rebound_participants
        ]
    return WorkPrecisionProblem(
        problem,
        duration,
        (
            *_galvi_participants(steps),
            rebound_participants[0],
            Participant("REBOUND IAS15, GLOBAL", ias15.IAS15, [once(**ias15.GLOBAL)]),
            Participant(
                "REBOUND IAS15, looser", ias15.IAS15, [once(**options) for options in looser]
            ),
            rebound_participants[1],
            Participant("REBOUND WHFast, default", whfast.WHFAST, steps(30, 120, **whfast.DEFAULT)),
            rebound_participants[2],
            Participant("REBOUND SABA, default", saba.SABA, steps(5, 20, **saba.DEFAULT)),
            *native_participants,
            Participant("heyoka", heyoka_taylor.HEYOKA, [once(**options) for options in taylor]),
            Participant("SciPy DOP853", DOP853, adaptive("tolerance", (1e-8, 1e-10))),
            *(
                Participant(label, contender, steps(*k, **options))
                for label, contender, k, options in extra
            ),
        ),
        truth,
    )


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


POLAR_DURATION = 20.0  # more than three revolutions
POLAR_STEPS = {4: (40, 56, 80, 112), 6: (28, 40, 56, 80), 8: (24, 28, 40, 56), 12: (24, 28)}


def kepler_polar(quick: bool) -> WorkPrecisionProblem:
    """An orbit of eccentricity 0.3 in r and phi.

    In a longer run phi grows, and with it the error that a tolerance allows.
    """
    problem = galvi.problems.kepler_polar()

    def truth() -> Truth:
        orbit = galvi.problems.kepler(problem.parameters["eccentricity"])
        x, y = KEPLER.run(orbit, POLAR_DURATION, {"samples": 1}).q[-1].tolist()
        # The mean anomaly, the time here, is within half a turn of the angle.
        turns = round((POLAR_DURATION - math.atan2(y, x)) / math.tau)
        end = np.array([math.hypot(x, y), math.atan2(y, x) + turns * math.tau])
        return Truth(end, 2.0 * EPS * float(end.max()), KEPLER.name)

    return on_coordinates(
        problem, POLAR_DURATION, quick, POLAR_STEPS, LAGRANGIAN_DOP853, truth, net_time=True
    )


def solar_system(quick: bool) -> WorkPrecisionProblem:
    """Sun and 8 planets: 200 years, or 20 when quick."""
    return planets(
        galvi.problems.solar_system(pluto=False),
        7_305.0 if quick else 73_050.0,
        87.97,
        quick,
        (
            ("REBOUND WHFast512", whfast512.WHFAST512, WISDOM_HOLMAN_STEPS, whfast512.BEST),
            (
                "REBOUND WHFast512, default",
                whfast512.WHFAST512,
                WISDOM_HOLMAN_STEPS[3::2],
                whfast512.DEFAULT,
            ),
            ("Stormer-Verlet", STORMER_VERLET, (100, 300), {}),
            ("symplectic Euler", SYMPLECTIC_EULER, (300,), {}),
        ),
    )


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


INACCURATE_LABELS = ("2 passes", "SciPy")  # errors of 1e-2, the latter after seconds


def applegate(quick: bool) -> WorkPrecisionProblem:
    """Applegate's outer planets: 10,000 years of 365 days, or 1000 when quick.

    The contenders of `outer_solar_system`, but for those of INACCURATE_LABELS, at the few
    settings of its quick form: the same planets, with other masses and another start.
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
    participants = [
        participant
        for participant in case.participants
        if not any(word in participant.label for word in INACCURATE_LABELS)
    ]
    return replace(case, participants=tuple(participants))
