"""Time runs with events: transits of three planets, with IAS15 and bisection beside them, and six
bodies whose events do not occur, beside the run without."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.timings.annotate import TIMER, annotate, timed
from benchmarks.timings.case import TRAJECTORY
from benchmarks.work_precision.problem import galvi_label
from galvi import NBody, Problem
from galvi.arrays import Array
from references.rebound import simulation as rebound_simulation
from references.rebound import transits as by_bisection

TIME_UNITS_PER_YEAR = 2.0 * math.pi  # with G = 1, au and solar masses
SECOND = TIME_UNITS_PER_YEAR / 365.25 / 86400.0
YEARS = 20.0
PERIODS = (0.5, 1.04, 2.13)  # years
MASSES = (2e-5, 6e-5, 3e-5)
PLANETS, STAR = (1, 2, 3), 0
STEPS_A_REVOLUTION = 10.0
OUTPUT_INTERVAL = 0.05 * TIME_UNITS_PER_YEAR  # between outputs of IAS15
METHOD = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
TRANSITS = [galvi.events.transit(planet, STAR, (1.0, 0.0, 0.0)) for planet in PLANETS]


def three_planets() -> Problem:
    """A star of one solar mass and planets on ellipses of small eccentricity in the plane z = 0."""
    masses = np.array([1.0, *MASSES])
    q, v = np.zeros((4, 3)), np.zeros((4, 3))
    for k, (years, mass, turn) in enumerate(zip(PERIODS, MASSES, (0.7, 2.9, 5.0), strict=True), 1):
        a, e = ((1.0 + mass) * years**2) ** (1.0 / 3.0), 0.02 * k
        speed = math.sqrt((1.0 + mass) / a * (1.0 - e) / (1.0 + e))  # at the apocentre
        q[k, :2] = a * (1.0 + e) * np.array([math.cos(turn), math.sin(turn)])
        v[k, :2] = speed * np.array([-math.sin(turn), math.cos(turn)])
    q, v = (x - masses @ x / masses.sum() for x in (q, v))
    return Problem(
        NBody(masses),
        q,
        v,
        name="three planets",
        units="au, solar mass, year / 2 pi",
        parameters={"bodies": ("star", "b", "c", "d")},
    )


def by_events(duration: float) -> list[Array]:
    """Mid-transit times of each planet, by galvi's events."""
    steps = math.ceil(duration / (PERIODS[0] * TIME_UNITS_PER_YEAR / STEPS_A_REVOLUTION))
    run = galvi.integrate(three_planets(), METHOD, duration / steps, steps)
    transits = galvi.find_events(run, TRANSITS)
    return [transits.t[transits.index == k] for k in range(len(PLANETS))]


def with_ias15(duration: float) -> list[Array]:
    """Mid-transit times of each planet, to a second, by bisection with REBOUND's IAS15."""
    return by_bisection.transits(three_planets(), PLANETS, STAR, duration, OUTPUT_INTERVAL, SECOND)


TRANSIT_SEARCHES: dict[str, tuple[str, Callable[[float], list[Array]], Callable[[], str]]] = {
    galvi_label(8): (f"events, {STEPS_A_REVOLUTION:g} steps a revolution", by_events, str),
    "REBOUND IAS15": ("bisection", with_ias15, rebound_simulation.missing),
}


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", TRANSIT_SEARCHES)
def test_transits(benchmark: Any, name: str) -> None:
    settings, times, missing = TRANSIT_SEARCHES[name]
    if missing():
        pytest.skip(missing())
    transits = timed(benchmark, lambda: times(YEARS * TIME_UNITS_PER_YEAR))
    counts = {"transits": sum(map(len, transits))}
    assert counts["transits"] == 69
    annotate(
        benchmark,
        problem=three_planets().name,
        error=None,
        counts=counts,
        status="",
        settings={"contender": name, "settings": settings, "years": YEARS},
        kind="reference",
    )


STEPS, STEP = 5000, 200.0  # days
APPROACHES = [galvi.events.within(k, k + 1, 0.5) for k in (1, 2, 3)]  # au: none comes so near


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", ["three events", "no events"])
def test_events_that_do_not_occur(benchmark: Any, name: str) -> None:
    problem = galvi.problems.outer_solar_system()
    events = APPROACHES if name == "three events" else ()
    run = timed(benchmark, lambda: galvi.integrate(problem, METHOD, STEP, STEPS, events=events))
    assert run.success and not (events and len(run.events))
    annotate(
        benchmark,
        problem=problem.name,
        error=None,
        counts=dict(run.counts),
        status=run.status,
        settings={"contender": f"galvi degree 8, Gauss 8, {name}", "settings": f"step={STEP:g} d"},
        kind=TRAJECTORY,
    )
