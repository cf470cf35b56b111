"""Time runs with events: transits of three planets, with IAS15 and bisection beside them, and six
bodies whose events do not occur, beside the run without."""

from __future__ import annotations

from typing import Any

import pytest

import galvi
from benchmarks.studies.transits import PARTICIPANTS, YEAR, three_planets
from benchmarks.timings.annotate import TIMER, annotate, timed
from benchmarks.timings.case import TRAJECTORY

YEARS = 20.0
FOUND = {"galvi degree 8, Gauss 8": PARTICIPANTS[1], "REBOUND IAS15": PARTICIPANTS[3]}


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", FOUND)
def test_transits(benchmark: Any, name: str) -> None:
    contender, settings, times, missing = FOUND[name]
    assert contender == name
    if missing():
        pytest.skip(missing())
    found = timed(benchmark, lambda: times(YEARS * YEAR))
    counts = {"transits": sum(map(len, found))}
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
NEAR = [galvi.events.within(k, k + 1, 0.5) for k in (1, 2, 3)]  # au: none comes so near


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", ["three events", "no events"])
def test_events_that_do_not_occur(benchmark: Any, name: str) -> None:
    problem = galvi.problems.outer_solar_system()
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    events = NEAR if name == "three events" else ()
    run = timed(benchmark, lambda: galvi.integrate(problem, method, STEP, STEPS, events=events))
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
