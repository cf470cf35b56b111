"""Point masses on eccentric orbits and in encounters, where steps must follow the motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

import galvi
from benchmarks.work_precision.galvi_methods import in_clock
from benchmarks.work_precision.problem import (
    EPS,
    Participant,
    Setting,
    Truth,
    WorkPrecisionProblem,
    adaptive,
    fixed,
)
from galvi import NBody, Problem
from references.closed_forms.kepler import KEPLER
from references.heyoka import taylor as heyoka_taylor
from references.rebound import ias15
from references.rebound.bulirsch_stoer import BULIRSCH_STOER
from references.rebound.mercurius import MERCURIUS
from references.rebound.trace import TRACE
from references.scipy.ivp import DOP853
from references.stored.planets import CASES as STORED
from references.stored.planets import STORED_TRUTH

REVOLUTIONS = 20.37  # ends away from the pericentre, with its phase


class Case(NamedTuple):
    """One problem of close encounters.

    Attributes
    ----------
    maps
        steps of TRACE and MERCURIUS, in the problem's unit of time; () where no mass dominates
    share
        fraction of the stored truth's duration that is run
    loose
        whether DOP853, which is far slower, runs at its loosest tolerance alone
    """

    map_steps: tuple[float, ...] = ()
    duration_fraction: float = 1.0
    only_loose_dop853: bool = False


MOST_UNROLLED_BODIES = 8  # bodies: heyoka takes minutes to compile the unrolled equations of 16
STEPS = {8: (1.0, 0.8, 0.6, 0.4, 0.3), 12: (1.2, 0.8, 0.5), 16: (1.6, 1.2, 0.8)}  # tau, by degree
CASES = {
    "burrau": Case(),
    "hd_80606": Case((0.1, 0.02), 0.2, True),
    "kozai": Case(duration_fraction=0.2, only_loose_dop853=True),
    "binary_meets_star": Case(),
    "sixteen_stars": Case(),
    "sitnikov": Case(duration_fraction=0.2),
}
ECCENTRICITIES = (0.9, 0.99, 0.999, 0.9999)


def encounter(case: str, quick: bool) -> WorkPrecisionProblem:
    """A problem whose truth is stored, as it needs quadruple precision."""
    (problem, full_duration), case_options = STORED[case], CASES[case]
    duration = case_options.duration_fraction * full_duration

    def truth() -> Truth:
        stored = STORED_TRUTH.run(problem, duration, {"samples": 1})
        speed = float(np.max(np.abs(stored.v[-1])))
        error = EPS * (float(np.max(np.abs(stored.q[-1]))) + duration * speed)
        text = f"{stored.method}; to the rounding of positions and times, {error:.0e}"
        return Truth(stored.q[-1], error, text)

    maps = [fixed(duration, math.ceil(duration / step)) for step in case_options.map_steps]
    by_maps = (
        [
            Participant("REBOUND TRACE", TRACE, maps),
            Participant("REBOUND MERCURIUS", MERCURIUS, maps),
        ]
        if maps
        else []
    )
    return _case(problem, duration, by_maps, truth, quick, case_options.only_loose_dop853)


def eccentric(e: float, quick: bool) -> WorkPrecisionProblem:
    """Two bodies of masses 0.7 and 0.3 on an orbit of eccentricity e, a = 1."""
    distance, speed = 1.0 - e, math.sqrt((1.0 + e) / (1.0 - e))
    masses = np.array([0.7, 0.3])
    fractions = np.array([[-masses[1]], [masses[0]]])
    problem = Problem(
        NBody(masses),
        fractions * [[distance, 0.0]],
        fractions * [[0.0, speed]],
        name=f"two bodies, e = {e:g}",
    )
    duration = REVOLUTIONS * math.tau

    def truth() -> Truth:
        end = KEPLER.run(problem, duration, {"samples": 1}).q[-1]
        return Truth(end, 4.0 * EPS * duration * 2.0, KEPLER.name)

    return _case(problem, duration, [], truth, quick, True)


def _case(
    problem: Problem,
    duration: float,
    by_maps: Sequence[Participant],
    truth: Any,
    quick: bool,
    only_loose_dop853: bool,
) -> WorkPrecisionProblem:
    def once(**options: Any) -> Setting:
        return {"samples": 1, **options}

    tolerances = (1e-9,) if quick or only_loose_dop853 else (1e-9, 1e-12)
    compact = {"compact_mode": True} if len(problem.q0) > MOST_UNROLLED_BODIES else {}
    taylor = [{**options, **compact} for options in (heyoka_taylor.DOUBLE, heyoka_taylor.BEST)]
    return WorkPrecisionProblem(
        problem,
        duration,
        (
            *(
                Participant(
                    clock_label(s),
                    in_clock(s, galvi.DynamicalTime()),
                    [{"step": h} for h in (sizes[::2] if quick else sizes)],
                )
                for s, sizes in STEPS.items()
            ),
            Participant("REBOUND IAS15", ias15.IAS15, [once(**ias15.DEFAULT)]),
            Participant("REBOUND IAS15, GLOBAL", ias15.IAS15, [once(**ias15.GLOBAL)]),
            Participant(
                "REBOUND IAS15, looser",
                ias15.IAS15,
                [once(**{**ias15.DEFAULT, "epsilon": 1e-5})],
            ),
            Participant("REBOUND BS", BULIRSCH_STOER, adaptive("tolerance", (1e-8, 1e-13))),
            *by_maps,
            Participant("heyoka", heyoka_taylor.HEYOKA, [once(**options) for options in taylor]),
            Participant("SciPy DOP853", DOP853, adaptive("tolerance", tolerances)),
        ),
        truth,
        net_time=True,
    )


def clock_label(stages: int) -> str:
    """The label of Gauss collocation in `galvi.DynamicalTime`."""
    return f"galvi clock, Gauss {stages}"


ENCOUNTERS = (
    *(partial(encounter, case) for case in CASES),
    *(partial(eccentric, e) for e in ECCENTRICITIES),
)
NOT_IN_QUICK = tuple(make for make in ENCOUNTERS if make.args[0] not in ("burrau", 0.99))
